"""Parallel runs of a campaign: in processes of this machine, or by Dask on many."""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from functools import partial
from multiprocessing import get_context
from pathlib import Path

from q2q_sim.experiments.campaign.campaign_flight import fly_and_judge
from q2q_sim.experiments.campaign.run_outcome import CRASH, RunOutcome
from q2q_sim.monitors.policies import Violation
from q2q_sim.scenarios.choices import ENGINES

RECYCLE = 200
"""Runs after which a process is replaced, which bounds memory leaks. By new pools: with max_tasks_per_child a
pool may deadlock, https://github.com/python/cpython/issues/115634."""

Fly = Callable[[int], RunOutcome]


def outcomes(engine: str, seeds: Sequence[int], jobs: int, kept: Path, air: str = "") -> Iterator[RunOutcome]:
    """Yield the outcome of every seed, in an air if one is named, in the order of completion.

    Raises:
        ValueError: an unknown engine, or one that is not installed.
    """
    fly = partial(fly_and_judge, kept=kept, air=air)
    if engine == "local":
        return _local(fly, seeds, jobs)
    if engine == "dask":
        return _dask(fly, seeds, jobs)
    raise ValueError(f"unknown engine {engine!r}: choose one of {', '.join(ENGINES)}")


def _local(fly: Fly, seeds: Sequence[int], jobs: int) -> Iterator[RunOutcome]:
    if jobs == 1:
        yield from map(fly, seeds)
        return
    for begin in range(0, len(seeds), jobs * RECYCLE):
        yield from _by_pool(fly, seeds[begin : begin + jobs * RECYCLE], jobs)


def _by_pool(fly: Fly, seeds: Sequence[int], jobs: int) -> Iterator[RunOutcome]:
    context = get_context("spawn")  # numba's and the solvers' threads do not survive a fork
    with ProcessPoolExecutor(jobs, mp_context=context) as pool:
        running = {pool.submit(fly, seed): seed for seed in seeds}
        try:
            for ended in as_completed(running):
                yield _result(ended, running[ended])
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def _result(ended: "Future[RunOutcome]", seed: int) -> RunOutcome:
    """Return a run's outcome; if its process died, a crash."""
    error = ended.exception()
    if error is None:
        return ended.result()
    what = Violation(CRASH, f"{type(error).__name__}: {error}"[:200], float("nan"), float("nan"), 0.0)
    return RunOutcome(seed, through_nodes=False, what="died", violations=(what,), seconds=0.0)


def _dask(fly: Fly, seeds: Sequence[int], jobs: int) -> Iterator[RunOutcome]:
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
        for ended in ended_first(client.map(fly, list(seeds), pure=False)):
            yield ended.result()
