"""Signals of a program by its scheduler, with SIGINT as Python has it at the start of a program.

Replaced are `signal.signal`, `signal.getsignal`, `os.kill` and `_thread.interrupt_main`. The processes of a
licence are forked from one that ignores SIGINT. A program may send that signal to itself: os.kill then
returns when the main thread has noticed it, as otherwise simulated time might pass meanwhile. interrupt_main
does not end a wait of the main thread, as in Python.
"""

import _thread
import os
import signal
from collections.abc import Callable
from types import FrameType

from q2q_sim.licence.program_process.cooperative_scheduler import CooperativeScheduler

NOTICED_S = 10.0
"""Longest wait for the main thread of a busy machine [s]."""
Handling = Callable[[int, FrameType | None], object]
Handler = Handling | int | None


def replace_signals(scheduler: CooperativeScheduler) -> None:
    """Replace the calls for the rest of this process; the calling thread is the program's main thread."""
    install, installed = signal.signal, signal.getsignal
    of_program: dict[int, Handling] = {}
    noticed = _thread.allocate_lock()
    noticed.acquire()

    def handle(number: int, frame: FrameType | None) -> None:
        if noticed.locked():
            noticed.release()
        scheduler.handle(lambda: of_program[number](number, frame))

    def handler_of(number: int) -> Handler:
        found = installed(number)
        return of_program[number] if found is handle else found

    def set_handler(number: int, handler: Handler) -> Handler:
        before = handler_of(number)
        install(number, handle if callable(handler) else handler)
        if callable(handler):
            of_program[number] = handler
        return before

    setattr(signal, "getsignal", handler_of)  # noqa: B010
    setattr(signal, "signal", set_handler)  # noqa: B010
    signal.signal(signal.SIGINT, signal.default_int_handler)
    is_handled = _Handled(lambda number: installed(number) is handle, of_program)
    _replace_kill(is_handled, noticed)
    _replace_interrupt_main(is_handled, scheduler)


class _Handled:
    """Which signals the program handles, and how."""

    def __init__(self, holds: Callable[[int], bool], of_program: dict[int, Handling]) -> None:
        self.holds = holds
        self._of_program = of_program

    def call(self, number: int) -> Callable[[], object]:
        """Return the call of a signal's handler."""
        return lambda: self._of_program[number](number, None)


def _replace_kill(handled: _Handled, noticed: _thread.LockType) -> None:
    send, main = os.kill, _thread.get_ident()

    def kill(pid: int, number: int) -> None:
        awaited = pid == os.getpid() and handled.holds(number) and _thread.get_ident() != main
        if awaited:
            noticed.acquire(blocking=False)
        send(pid, number)
        if awaited:
            noticed.acquire(timeout=NOTICED_S)

    setattr(os, "kill", kill)  # noqa: B010


def _replace_interrupt_main(handled: _Handled, scheduler: CooperativeScheduler) -> None:
    interrupt, main = _thread.interrupt_main, _thread.get_ident()

    def interrupt_main(number: signal.Signals = signal.SIGINT) -> None:
        if not handled.holds(number):
            interrupt(number)
        elif _thread.get_ident() == main:
            scheduler.handle(handled.call(number))
        else:
            scheduler.handle_next(handled.call(number))

    setattr(_thread, "interrupt_main", interrupt_main)  # noqa: B010
