"""Locks and threads of Python by the scheduler of a program (CPython 3.11 and 3.12), with its clocks.

Replaced are the names through which Python's own modules and programs reach them: sleeping and the clocks
(patched_time), the locks of `threading` (with them events, conditions, timers, queues and executors,
which are made of locks), the start and end of threads, and the waiting of `selectors` (and so of asyncio).
Not replaced: other waiting for sockets, processes, and waiting inside C code, during which the clock of the
program stands still. Processes of `multiprocessing` are refused: in them cflib would look for real radios on
the real clock.

A thread that computes for BUSY_S of processor time without waiting, such as a loop that waits for a variable,
spends that time on the clock and lets the other threads go on.
"""

import _thread
import math
import queue
import selectors
import signal
import sys
import threading
from collections.abc import Callable
from multiprocessing.process import BaseProcess
from types import FrameType, TracebackType
from typing import NoReturn

from q2q_sim.licence.program_process.cooperative_scheduler import CooperativeScheduler
from q2q_sim.licence.program_process.patched_time import replace_clocks

BUSY_S = 0.2
"""Processor time between two looks at the thread that has the turn [s]."""
SWITCH_S = 5e-4
"""Longest time for which Python runs one of two threads that compute [s]."""

_start_thread = _thread.start_new_thread


def patch_threading(scheduler: CooperativeScheduler) -> None:
    """Replace the calls for the rest of this process; the calling thread is the program's main thread."""
    BaseProcess.start = _refuse_process  # type: ignore[assignment, method-assign]
    replace_clocks(scheduler)
    _replace_locks(scheduler)
    _replace_threads(scheduler)
    _replace_selectors(scheduler)


def _refuse_process(_: BaseProcess) -> NoReturn:
    where = "the emulated vehicles are in this one; use threads"
    raise RuntimeError(f"a licence cannot start processes (multiprocessing): {where}")


class PatchedLock:
    """Lock with the interface of `threading.Lock`."""

    scheduler: CooperativeScheduler

    def __init__(self) -> None:
        self._held = False

    def acquire(self, blocking: bool = True, timeout: float = -1) -> bool:
        """Acquire the lock, as threading.Lock does."""
        self.scheduler.resume()
        if self._held and blocking:
            until = float("inf") if timeout < 0 else self.scheduler.now + timeout
            self.scheduler.wait(self._free, until)
        if self._held:
            return False
        self._held = True
        return True

    def release(self) -> None:
        """Release the lock."""
        if not self._held:
            raise RuntimeError("release unlocked lock")
        self._held = False

    def locked(self) -> bool:
        """Return whether the lock is held."""
        return self._held

    def _free(self) -> bool:
        return not self._held

    def __enter__(self) -> bool:
        """Acquire the lock."""
        return self.acquire()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Release the lock."""
        self.release()


def _replace_locks(scheduler: CooperativeScheduler) -> None:
    PatchedLock.scheduler = scheduler
    for name in ("Lock", "_allocate_lock"):
        setattr(threading, name, PatchedLock)
    setattr(threading, "_CRLock", None)  # noqa: B010  threading.RLock is then made of _allocate_lock
    setattr(queue, "SimpleQueue", queue._PySimpleQueue)  # type: ignore[attr-defined]  # noqa: B010, SLF001


def _replace_threads(scheduler: CooperativeScheduler) -> None:
    ends: dict[int, PatchedLock] = {}

    def end_of_thread() -> PatchedLock:
        """Return the lock that `join` acquires, released when the calling thread ends."""
        return ends.setdefault(_thread.get_ident(), PatchedLock())

    def start(run: Callable[..., object], args: tuple[object, ...] = ()) -> int:
        gate = scheduler.enter()

        def body() -> None:
            signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGPROF})  # looks are for the main thread
            scheduler.take(gate)
            try:
                run(*args)
            finally:
                scheduler.claim()
                ended = ends.pop(_thread.get_ident(), None)
                if ended is not None and ended.locked():
                    ended.release()
                scheduler.leave()

        return _start_thread(body, ())

    setattr(threading, "_start_new_thread", start)  # noqa: B010
    setattr(threading, "_set_sentinel", end_of_thread)  # noqa: B010


def _replace_selectors(scheduler: CooperativeScheduler) -> None:
    Ready = list[tuple[selectors.SelectorKey, int]]
    look = selectors.DefaultSelector.select

    def select(self: selectors.DefaultSelector, timeout: float | None = None) -> Ready:
        found: Ready = []

        def ready() -> bool:
            found[:] = look(self, 0.0)
            return bool(found)

        if not ready() and timeout != 0:
            scheduler.wait(ready, math.inf if timeout is None else scheduler.now + max(timeout, 0.0))
        return found

    setattr(selectors.DefaultSelector, "select", select)  # noqa: B010


def watch_threads(scheduler: CooperativeScheduler) -> None:
    """Let time pass while a thread computes from now on; not while cflib is imported before."""
    main = _thread.get_ident()
    seen = -1

    def look(_: int, __: FrameType | None) -> None:
        nonlocal seen
        if not scheduler.is_deciding and (scheduler.given == seen or scheduler.computes_on):
            spend = scheduler.spend if scheduler.holder == main else scheduler.spend_for_holder
            spend(BUSY_S)
        seen = scheduler.given

    sys.setswitchinterval(SWITCH_S)
    signal.signal(signal.SIGPROF, look)
    signal.setitimer(signal.ITIMER_PROF, BUSY_S, BUSY_S)
