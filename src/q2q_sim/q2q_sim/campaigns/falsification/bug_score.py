"""Score of a search by seeded bugs: in how many runs it finds each, compared with blind drawing.

Both have the same number of runs and the same checks. A bug is found by a run that violates a policy or
postcondition with the bug that it does not violate without.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain, count, islice
from time import perf_counter

from q2q_sim.campaigns.falsification.candidate_flight import CandidateFlight, fly_candidate
from q2q_sim.campaigns.falsification.guided_search import LENGTH, SEARCH, guided_runs
from q2q_sim.campaigns.falsification.seeded_bugs import SEEDED_BUGS
from q2q_sim.campaigns.random_runs.random_run import Run, draw_run


@dataclass(frozen=True, slots=True)
class BugScore:
    """Runs until a seeded bug was found; 0 where it was not."""

    bug: str
    runs: int
    """Runs that each search may take."""
    seed: int
    """First seed of both."""
    guided: int
    blind: int
    seconds: float
    air: str = ""
    search: str = ""
    """SEARCH of the guided one."""


def score_bugs(number: int, runs: int, seed: int, air: str = "") -> BugScore:
    """Return the score of one of SEEDED_BUGS; the searches begin at a seed."""
    began, bug = perf_counter(), SEEDED_BUGS[number]

    def judge(run: Run) -> CandidateFlight:
        with bug.seeded():
            return fly_candidate(run)

    searches = chain.from_iterable(guided_runs(seed + k, LENGTH, judge, air) for k in count())
    guided = ((one.run, one.flight) for one in searches)
    blind = ((run, judge(run)) for run in (draw_run(seed + k, air) for k in count()))
    found = _first(guided, runs), _first(blind, runs)
    return BugScore(bug.name, runs, seed, *found, perf_counter() - began, air, SEARCH)


def unscored(number: int) -> BugScore:
    """Raise ChildProcessError: a process died, which says nothing about the search."""
    raise ChildProcessError(f"the process that searched for {SEEDED_BUGS[number].name} died: run again")


def _first(flown: Iterator[tuple[Run, CandidateFlight]], runs: int) -> int:
    """Return the number of the first of `runs` flights that shows the bug; 0 if none does."""
    for number, (run, flight) in enumerate(islice(flown, runs), start=1):
        if flight.violations and not flight.policies <= fly_candidate(run).policies:
            return number
    return 0
