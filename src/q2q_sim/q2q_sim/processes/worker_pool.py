"""Processes that work for this one, and end with it even if it is killed.

A pool of the standard library leaves its processes behind then: each of them holds both ends of the pipe at
which it waits. On Ctrl-C, which reaches every process, each of them prints a traceback while it starts or
imports its work; here it ends without a word.
"""

import os
import signal
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from multiprocessing.context import SpawnContext, SpawnProcess
from multiprocessing.resource_tracker import ensure_running
from types import FrameType

from q2q_sim.processes.parent_death import live_with

STATUS = 130
"""Exit status after Ctrl-C, as shells have it: 128 + SIGINT."""


class Interrupted(KeyboardInterrupt, SystemExit):
    """Interrupt of work, sent to who waits for it; elsewhere it ends the process without a traceback."""


def worker_pool(
    workers: int, first: Callable[[], None] | None = None, recycle: int | None = None
) -> ProcessPoolExecutor:
    """Return a pool of spawned processes: threads of numba, solvers and middleware do not survive a fork.

    Args:
        workers: number of processes.
        first: what each does before its first task.
        recycle: tasks after which a process is replaced; None for never.
    """
    return ProcessPoolExecutor(
        workers,
        mp_context=_Context(),
        initializer=_begin,
        initargs=(os.getpid(), first),
        max_tasks_per_child=recycle,
    )


class _Process(SpawnProcess):
    """Process that starts with SIGINT blocked, until `_begin`."""

    def start(self) -> None:
        """Start the process."""
        ensure_running()  # which unblocks SIGINT
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            super().start()
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)


class _Context(SpawnContext):
    """Start of such processes."""

    Process = _Process


def _begin(parent: int, first: Callable[[], None] | None) -> None:
    signal.signal(signal.SIGINT, lambda *_: os._exit(STATUS))  # nothing needs cleaning up yet
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    signal.signal(signal.SIGINT, _interrupt)
    live_with(parent)
    if first is not None:
        first()


def _interrupt(_: int, __: FrameType | None) -> None:
    raise Interrupted(STATUS)
