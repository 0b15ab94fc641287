"""Outcomes of the runs of a campaign, flown in parallel."""

from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

from q2q_sim.campaigns.random_runs.campaign_flight import fly_and_judge
from q2q_sim.campaigns.random_runs.run_outcome import CRASH, DIED, RunOutcome
from q2q_sim.monitors.policies import Violation
from q2q_sim.processes.parallel_work import Workers, spread_work


def run_outcomes(
    engine: str, seeds: Sequence[int], jobs: int, kept: Path, air: str = ""
) -> Iterator[RunOutcome]:
    """Yield the outcome of every seed, in an air if one is named, in the order of completion.

    Raises:
        ValueError: an unknown engine, or one that is not installed.
    """
    fly, died = partial(fly_and_judge, kept=kept, air=air), partial(_died, air=air)
    return spread_work(Workers(engine, jobs), fly, seeds, died)


def _died(seed: int, air: str) -> RunOutcome:
    """Return the crash of a run whose process died."""
    what = Violation(CRASH, "its process died when flown alone", float("nan"), float("nan"), 0.0)
    return RunOutcome(seed, through_nodes=False, what=DIED, violations=(what,), seconds=0.0, air=air)
