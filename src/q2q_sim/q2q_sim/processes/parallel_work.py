"""Parallel work on numbers, such as the runs of seeds: in processes of this machine, or by Dask on many."""

import gc
import os
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import as_completed
from concurrent.futures.process import BrokenProcessPool
from typing import NamedTuple, TypeVar

from q2q_sim.processes.worker_pool import worker_pool
from q2q_sim.scenarios.choices import ENGINES

RECYCLE = 2000
"""Results after which a process is replaced, which bounds memory leaks; a start takes as long as 15 runs. By
new pools: with max_tasks_per_child one may deadlock, https://github.com/python/cpython/issues/115634."""

Result = TypeVar("Result")
Work = Callable[[int], Result]
"""Work on a number, such as the run of a seed."""
Died = Callable[[int], Result]
"""Result of work on a number whose process died, alone with it."""
NO_START = (
    "the processes of parallel work ended before they began, as they import the main script (their output "
    'says why): call parallel work under `if __name__ == "__main__":` in a script that is a file, not '
    "standard input; or give jobs=1"
)


class Workers(NamedTuple):
    """Who works in parallel."""

    engine: str
    jobs: int
    """Processes of this machine."""


def spread_work(
    workers: Workers, work: Work[Result], numbers: Sequence[int], died: Died[Result]
) -> Iterator[Result]:
    """Yield the result of work on every number, in the order of completion; an error of work is raised.

    Raises:
        ValueError: an unknown engine, or one that is not installed.
        RuntimeError: a local process ended before it began, as where the main script is not guarded.
    """
    if workers.engine == "local":
        return _local(work, numbers, workers.jobs, died)
    if workers.engine == "dask":
        return _dask(work, numbers, workers.jobs)
    raise ValueError(f"unknown engine {workers.engine!r}: choose one of {', '.join(ENGINES)}")


class _NotBegunError(Exception):
    """Error of a process alone that ended before it began its work."""


def _local(work: Work[Result], numbers: Sequence[int], jobs: int, died: Died[Result]) -> Iterator[Result]:
    for begin in range(0, len(numbers), jobs * RECYCLE):
        yield from _by_pools(work, numbers[begin : begin + jobs * RECYCLE], jobs, died)


def _by_pools(work: Work[Result], left: Sequence[int], jobs: int, died: Died[Result]) -> Iterator[Result]:
    """Yield the results; a pool in which a process died is replaced, and what it worked on is done alone."""
    while left:
        left = yield from _by_pool(work, left, jobs)
        suspects, left = left[:jobs], left[jobs:]
        for number in suspects:
            if (yield from _alone(work, number)):
                yield died(number)


def _alone(work: Work[Result], number: int) -> Generator[Result, None, Sequence[int]]:
    """Yield the result of a process of its own; return the number if that died at its work.

    A process that ends before it begins, as one that is killed for its memory, is replaced once.
    """
    try:
        return (yield from _by_pool(work, [number], 1))
    except _NotBegunError:
        pass
    try:
        return (yield from _by_pool(work, [number], 1))
    except _NotBegunError as again:
        raise RuntimeError(NO_START) from again


def _by_pool(work: Work[Result], numbers: Sequence[int], jobs: int) -> Generator[Result, None, Sequence[int]]:
    """Yield results until a process dies; return the numbers without one, the first begun first."""
    left, pool = dict(enumerate(numbers)), worker_pool(jobs, freeze_imports)
    began = pool.submit(os.getpid)
    try:
        running = {pool.submit(work, number): place for place, number in enumerate(numbers)}
        for ended in as_completed(running):
            result = ended.result()
            del left[running[ended]]
            yield result
    except BrokenProcessPool as broken:
        # of several processes one may die at its work before another has begun; one alone begins first
        if jobs == 1 and began.exception() is not None:
            raise _NotBegunError from broken
    finally:
        # a pool that is not waited for may be collected before it cancels, and then does all that is left
        pool.shutdown(wait=True, cancel_futures=True)
    return list(left.values())


def freeze_imports() -> None:
    """Leave what has been imported, which is never freed, out of later garbage collections."""
    gc.freeze()


def _dask(work: Work[Result], numbers: Sequence[int], jobs: int) -> Iterator[Result]:
    """Run on the cluster at DASK_SCHEDULER_ADDRESS, else on a local one of `jobs` processes."""
    try:
        from dask.distributed import Client
        from dask.distributed import as_completed as ended_first
    except ImportError as missing:
        raise ValueError("engine dask: install it by `pip install -r requirements/campaign.txt`") from missing
    import dask

    address = dask.config.get("scheduler-address", None)
    where = {"address": address} if address else {"n_workers": jobs, "threads_per_worker": 1}
    with Client(**where, dashboard_address=None) as client:
        for ended in ended_first(client.map(work, list(numbers), pure=False)):
            yield ended.result()
