"""Attack: search of faults that leave the policies the least margin, in a bounded number of runs.

1. Survey: scenarios, rooms and controllers as random campaigns draw them, half of them with the safe
   replanner, with faults that coincide (`coincidence`).
2. Descents: of the policies whose margin fell most in the survey, each from its run of minimum margin, CMA-ES
   (N. Hansen, "The CMA evolution strategy: a tutorial", arXiv:1604.00772) moves the vector of the faults down
   the margin of that policy alone: margins of all policies in one number would hide each other.

The first violation ends the attack. A campaign is many attacks, so each is a restart.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from q2q_model.signals.values import Array
from q2q_sim.experiments.campaign.random_run import CALM_S, Run, draw_run
from q2q_sim.experiments.falsification.attack_case import with_faults
from q2q_sim.experiments.falsification.attacked_flight import WORST, AttackedFlight
from q2q_sim.experiments.falsification.coincidence import CoincidingFaults
from q2q_sim.experiments.falsification.fault_vector import SLOTS, faults_of, vector_of
from q2q_sim.random_streams import stream

SURVEY = 30
"""Runs of the survey."""
GENERATION = 5
"""Runs of a generation of CMA-ES: the best of them make the next mean."""
GENERATIONS = 2
"""Generations of a descent."""
DESCENTS = 2
"""Policies whose margin is descended."""
LENGTH = SURVEY + DESCENTS * GENERATIONS * GENERATION
"""Runs of an attack."""
SEARCH = f"{SURVEY}+{DESCENTS}*{GENERATIONS}*{GENERATION}"
"""Name of the search in kept work, which another search does not resume."""
STEP = 0.1
"""First standard deviation of CMA-ES, of a range from 0 to 1."""

Judge = Callable[[Run], AttackedFlight]


class AttackRun(NamedTuple):
    """Run of an attack, and what it came to."""

    run: Run
    vector: Array
    flight: AttackedFlight


@dataclass(frozen=True, slots=True)
class Attack:
    """Outcome of an attack."""

    runs: int
    violated: Run | None
    """First run with a violation, if any."""
    policies: frozenset[str]
    """Policies that it violates."""
    thrust_exceeded: int = 0
    """Runs in which the thrust of some vehicle was exceeded."""
    unpredicted_downwash: int = 0
    """Runs in which one was flown blind in a downwash that nothing could predict."""


def attack(seed: int, length: int, judge: Judge, air: str = "") -> Attack:
    """Return the outcome of an attack of at most `length` runs."""
    runs = thrust_exceeded = unpredicted_downwash = 0
    for attempt in attack_runs(seed, length, judge, air):
        runs += 1
        thrust_exceeded += attempt.flight.thrust_exceeded
        unpredicted_downwash += attempt.flight.unpredicted_downwash
        if attempt.flight.violations:
            return Attack(runs, attempt.run, attempt.flight.policies, thrust_exceeded, unpredicted_downwash)
    return Attack(runs, None, frozenset(), thrust_exceeded, unpredicted_downwash)


def attack_runs(seed: int, length: int, judge: Judge, air: str = "") -> Iterator[AttackRun]:
    """Yield at most `length` runs of an attack."""
    surveyed = []
    for attempt in _survey(seed, min(length, SURVEY), judge, air):
        surveyed.append(attempt)
        yield attempt
    left = length - len(surveyed)
    policies = falling_policies(surveyed)[:DESCENTS] if left > 0 else ()
    for number, policy in enumerate(policies):
        worst = min(surveyed, key=lambda one: one.flight.margins[policy])
        share = left // (len(policies) - number)
        yield from _descent(seed, share, judge, (policy, worst))
        left -= share


def falling_policies(surveyed: Sequence[AttackRun]) -> tuple[str, ...]:
    """Return the policies by how far the least margin of the runs is below the median, the farthest first."""
    depths = {}
    for policy in surveyed[0].flight.margins:
        known = [one.flight.margins[policy] for one in surveyed if one.flight.margins[policy] < WORST]
        if known and (depth := float(np.median(known)) - min(known)) > 0.0:
            depths[policy] = depth
    return tuple(sorted(depths, key=lambda policy: -depths[policy]))


def _survey(seed: int, length: int, judge: Judge, air: str) -> Iterator[AttackRun]:
    rng = stream(seed, "guided attack")
    for number in range(length):
        run = draw_run(seed * SURVEY + number, air, replan="safe" if number % 2 else "none")
        scenario, last = run.scenario, last_fault_start(run)
        vector = vector_of(CoincidingFaults(rng, scenario, last).drawn(SLOTS // 2), scenario.names, last)
        run = with_fault_vector(run, vector)
        yield AttackRun(run, vector, judge(run))


def _descent(seed: int, length: int, judge: Judge, begin: tuple[str, AttackRun]) -> Iterator[AttackRun]:
    """Yield `length` runs down the margin of a policy, generation by generation."""
    import cma  # takes seconds to load

    policy, worst = begin
    options = {"bounds": [0.0, 1.0], "seed": seed + 1, "popsize": GENERATION, "verbose": -9}
    search = cma.CMAEvolutionStrategy(worst.vector, STEP, options)
    while length > 0:
        tried = []
        for vector in search.ask()[:length]:
            run = with_fault_vector(worst.run, vector)
            tried.append(AttackRun(run, vector, judge(run)))
            yield tried[-1]
        length -= len(tried)
        if length > 0:
            search.tell([one.vector for one in tried], [one.flight.margins[policy] for one in tried])


def with_fault_vector(run: Run, vector: Array) -> Run:
    """Return a run with the faults of a vector in place of its own."""
    return with_faults(run, faults_of(vector, run.scenario.names, last_fault_start(run)))


def last_fault_start(run: Run) -> float:
    """Return the last time at which a fault may start [s]."""
    return run.scenario.duration - CALM_S
