"""Time pure runs of a campaign: flown by closed_loop and judged, in processor time of one core.

Runs are those of successive seeds, by controller and replanner, in a process like those of campaigns, after
one run of each kind that loads its code. The reference is real time: the length of the same flights.
"""

from collections.abc import Iterator
from itertools import count, islice
from time import process_time

from q2q_sim.campaigns.random_runs.campaign_flight import fly_pure
from q2q_sim.campaigns.random_runs.random_run import Run, draw_run
from q2q_sim.processes.parallel_work import freeze_imports
from row import Row

RUNS = {("pid", "none"): 40, ("pid", "safe"): 10, ("mpc", "none"): 10}
"""Runs of each controller and replanner."""
FIRST_SEED = 100_000
"""Above the seeds of campaigns."""


def run() -> list[Row]:
    """Return runs per second and the time of a run, of each controller and replanner."""
    rows = []
    freeze_imports()
    for (controller, replan), runs in RUNS.items():
        first, *timed = islice(_runs(controller, replan), runs + 1)
        fly_pure(first)
        took = [_seconds(one) for one in timed]
        name = f"campaign run by {controller}, replanner {replan}"
        length = sum(one.scenario.duration for one in timed)
        rows.append(Row(name, sum(took) / runs, "s", "real time", length / sum(took)))
        rows.append(Row(f"{name}, on one core", runs / sum(took), "1/s"))
    return rows


def _runs(controller: str, replan: str) -> Iterator[Run]:
    drawn_runs = map(draw_run, count(FIRST_SEED))
    return (one for one in drawn_runs if (one.options.controller, one.options.replan) == (controller, replan))


def _seconds(one: Run) -> float:
    began = process_time()
    fly_pure(one)
    return process_time() - began
