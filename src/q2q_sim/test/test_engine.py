"""Parallel work ends with whoever asked for it."""

import multiprocessing
import time

from q2q_sim.experiments.campaign.engine import ParallelRuns, spread_work


def test_after_an_interruption_no_process_works_on() -> None:
    """Ctrl-C closes the generator; a pool that is not waited for may do all that is left."""
    results = spread_work(ParallelRuns("local", 2), time.sleep, [0] * 100, lambda _, error: print(error))
    next(iter(results))
    results.close()
    assert multiprocessing.active_children() == []
