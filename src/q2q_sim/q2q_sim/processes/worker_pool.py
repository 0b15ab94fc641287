"""Processes that work for this one, and end with it even if it is killed.

A pool of the standard library leaves its processes behind then: each of them holds both ends of the pipe at
which it waits.
"""

import os
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

from q2q_sim.processes.parent_death import live_with


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
        mp_context=get_context("spawn"),
        initializer=_begin,
        initargs=(os.getpid(), first),
        max_tasks_per_child=recycle,
    )


def _begin(parent: int, first: Callable[[], None] | None) -> None:
    live_with(parent)
    if first is not None:
        first()
