"""Guided search of faults that leave the policies the least margin, in a bounded number of runs.

1. Random phase: scenarios, rooms and controllers as random campaigns draw them, half of them with the safe
   replanner, with faults that coincide (`coincidence`).
2. Local searches: of the policies whose margin fell most in the random phase, each from its run of minimum
   margin, CMA-ES (N. Hansen, "The CMA evolution strategy: a tutorial", arXiv:1604.00772) moves the vector of
   the faults down the margin of that policy alone: margins of all policies in one number would hide each
   other.

The first violation ends the search. A campaign is many searches, so each is a restart.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from q2q_model.signals.values import Array
from q2q_sim.campaigns.falsification.candidate_flight import WORST, CandidateFlight
from q2q_sim.campaigns.falsification.coincidence import CoincidingFaults
from q2q_sim.campaigns.falsification.counterexample import with_faults
from q2q_sim.campaigns.falsification.fault_vector import SLOTS, faults_of, vector_of
from q2q_sim.campaigns.random_runs.random_run import CALM_S, Run, draw_run
from q2q_sim.random_streams import stream

RANDOM_RUNS = 30
"""Runs of the random phase."""
GENERATION = 5
"""Runs of a generation of CMA-ES: the best of them make the next mean."""
GENERATIONS = 2
"""Generations of a local search."""
LOCAL_SEARCHES = 2
"""Policies whose margin a local search lowers."""
LENGTH = RANDOM_RUNS + LOCAL_SEARCHES * GENERATIONS * GENERATION
"""Runs of a guided search."""
SEARCH = f"{RANDOM_RUNS}+{LOCAL_SEARCHES}*{GENERATIONS}*{GENERATION}"
"""Name of the search in kept work, which another search does not resume."""
STEP = 0.1
"""First standard deviation of CMA-ES, of a range from 0 to 1."""

Judge = Callable[[Run], CandidateFlight]


class GuidedRun(NamedTuple):
    """Run of a guided search, and what it came to."""

    run: Run
    vector: Array
    flight: CandidateFlight


@dataclass(frozen=True, slots=True)
class GuidedSearch:
    """Outcome of a guided search."""

    runs: int
    violated: Run | None
    """First run with a violation, if any."""
    policies: frozenset[str]
    """Policies that it violates."""
    thrust_exceeded: int
    """Runs in which the thrust of some vehicle was exceeded."""
    unpredicted_downwash: int
    """Runs in which one was flown without measurements in a downwash that nothing could predict."""


def guided_search(seed: int, length: int, judge: Judge, air: str = "") -> GuidedSearch:
    """Return the outcome of a guided search of at most `length` runs."""
    runs = thrust_exceeded = unpredicted_downwash = 0
    for attempt in guided_runs(seed, length, judge, air):
        runs += 1
        thrust_exceeded += attempt.flight.thrust_exceeded
        unpredicted_downwash += attempt.flight.unpredicted_downwash
        if attempt.flight.violations:
            return GuidedSearch(
                runs, attempt.run, attempt.flight.policies, thrust_exceeded, unpredicted_downwash
            )
    return GuidedSearch(runs, None, frozenset(), thrust_exceeded, unpredicted_downwash)


def guided_runs(seed: int, length: int, judge: Judge, air: str = "") -> Iterator[GuidedRun]:
    """Yield at most `length` runs of a guided search."""
    drawn = []
    for attempt in _random_phase(seed, min(length, RANDOM_RUNS), judge, air):
        drawn.append(attempt)
        yield attempt
    left = length - len(drawn)
    policies = falling_policies(drawn)[:LOCAL_SEARCHES] if left > 0 else ()
    for number, policy in enumerate(policies):
        worst = min(drawn, key=lambda one: one.flight.margins[policy])
        share = left // (len(policies) - number)
        yield from _local_search(seed, share, judge, (policy, worst))
        left -= share


def falling_policies(drawn: Sequence[GuidedRun]) -> tuple[str, ...]:
    """Return the policies by how far the least margin of the runs is below the median, the farthest first."""
    depths = {}
    for policy in drawn[0].flight.margins:
        known = [one.flight.margins[policy] for one in drawn if one.flight.margins[policy] < WORST]
        if known and (depth := float(np.median(known)) - min(known)) > 0.0:
            depths[policy] = depth
    return tuple(sorted(depths, key=lambda policy: -depths[policy]))


def _random_phase(seed: int, length: int, judge: Judge, air: str) -> Iterator[GuidedRun]:
    rng = stream(seed, "guided attack")
    for number in range(length):
        run = draw_run(seed * RANDOM_RUNS + number, air, replan="safe" if number % 2 else "none")
        scenario, last = run.scenario, last_fault_start(run)
        vector = vector_of(CoincidingFaults(rng, scenario, last).drawn(SLOTS // 2), scenario.names, last)
        run = with_fault_vector(run, vector)
        yield GuidedRun(run, vector, judge(run))


def _local_search(seed: int, length: int, judge: Judge, begin: tuple[str, GuidedRun]) -> Iterator[GuidedRun]:
    """Yield `length` runs down the margin of a policy, generation by generation."""
    import cma  # takes seconds to load

    policy, worst = begin
    options = {"bounds": [0.0, 1.0], "seed": seed + 1, "popsize": GENERATION, "verbose": -9}
    search = cma.CMAEvolutionStrategy(worst.vector, STEP, options)
    while length > 0:
        tried = []
        for vector in search.ask()[:length]:
            run = with_fault_vector(worst.run, vector)
            tried.append(GuidedRun(run, vector, judge(run)))
            yield tried[-1]
        length -= len(tried)
        if length > 0:
            search.tell([one.vector for one in tried], [one.flight.margins[policy] for one in tried])


def with_fault_vector(run: Run, vector: Array) -> Run:
    """Return a run with the faults of a vector (DIMENSION,), as of `faults_of`, in place of its own."""
    return with_faults(run, faults_of(vector, run.scenario.names, last_fault_start(run)))


def last_fault_start(run: Run) -> float:
    """Return the last time at which a fault may start [s]."""
    return run.scenario.duration - CALM_S
