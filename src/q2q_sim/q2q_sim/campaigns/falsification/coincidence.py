"""Faults that coincide: pairs of them, at moments of a plan at which a fault is likely to matter.

Faults that fall on each other reveal more than the same faults apart, and seldom do in blind drawing. Four
faults are two pairs:

1. The first of a pair acts at a moment of the plan: a vehicle is fastest, or two are nearest to each other.
2. The second begins with the first, at its end (a chain), or within it, on the same vehicle or another.

Durations and sizes are drawn near the ends of their ranges more often than in the middle (arcsine law).
"""

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from q2q_model.signals.values import Names
from q2q_model.trajectory.polynomials import setpoint_at
from q2q_sim.faults.drawn_faults import LENGTHS, SIZES, earliest_start, kinds_among
from q2q_sim.faults.faults import KINDS, Fault
from q2q_sim.loop.flight_blocks import plan_of
from q2q_sim.scenarios.scenario import Scenario

FAMILIES = (
    ("dropout", "nan"),
    ("outlier", "jump", "flip", "swap"),
    ("stale", "repeated", "late", "reordered", "clock_jump"),
    ("radio_loss", "battery_sag", "weak_rotor"),
)
"""Kinds that hide vehicles, mislead, shift time, and weaken."""
SHARES = (0.3, 0.3, 0.3, 0.1)
"""Share of each family: gates and fallbacks answer to the first three."""
ARCSINE = 0.5
"""Both parameters of the beta distribution of durations and sizes."""
GRID_S = 0.05
"""Times at which a plan is examined [s]."""
MOVING = 0.1
"""Speed from which a vehicle moves [m/s]."""


@dataclass(frozen=True, slots=True)
class Moment:
    """Time of a plan at which a fault of a vehicle is likely to matter."""

    t: float
    vehicle: str
    """The fastest one, or the upper one of a pair."""


def critical_moments(scenario: Scenario, last: float) -> tuple[Moment, ...]:
    """Return the moments of a scenario's plan up to `last` [s]."""
    plan = plan_of(scenario)
    times = np.arange(0.0, last, GRID_S)
    found = [setpoint_at(plan, float(t)) for t in times]
    pos, speed = (
        np.stack([one.pos for one in found]),
        np.stack([np.linalg.norm(one.vel, axis=1) for one in found]),
    )
    fastest = [
        Moment(float(times[speed[:, row].argmax()]), name)
        for row, name in enumerate(plan.names)
        if speed[:, row].max() > MOVING
    ]
    nearest = []
    for i, j in combinations(range(len(plan.names)), 2):
        k = int(np.linalg.norm(pos[:, i, :2] - pos[:, j, :2], axis=1).argmin())
        nearest.append(Moment(float(times[k]), plan.names[i if pos[k, i, 2] > pos[k, j, 2] else j]))
    return (*fastest, *nearest)


class CoincidingFaults:
    """Drawing of coinciding faults for one flight."""

    def __init__(self, rng: np.random.Generator, scenario: Scenario, last: float) -> None:
        """Draw from `rng` faults that begin at most at `last` [s]."""
        self._rng, self._names, self._last = rng, scenario.names, last
        self._moments = critical_moments(scenario, last)

    def drawn(self, pairs: int) -> tuple[Fault, ...]:
        """Return pairs of faults, in random order."""
        found: list[Fault] = []
        for _ in range(pairs):
            first = self._first()
            found += [first, self._second(first)]
        return tuple(found[k] for k in self._rng.permutation(len(found)))

    def _first(self) -> Fault:
        moment = self._moments[int(self._rng.integers(len(self._moments)))]
        kind, duration = self._kind_and_duration()
        start = moment.t - self._rng.uniform(0.5, 1.0) * duration  # its effect grows while it lasts
        return self._fault(kind, start, duration, moment.vehicle)

    def _second(self, first: Fault) -> Fault:
        kind, duration = self._kind_and_duration()
        share = float(self._rng.choice([0.0, 1.0, self._rng.random()]))
        names = first.vehicles or self._names
        other = self._names if self._rng.random() < 0.5 else names
        return self._fault(kind, first.start + share * first.duration, duration, str(self._rng.choice(other)))

    def _kind_and_duration(self) -> tuple[str, float]:
        family = FAMILIES[int(self._rng.choice(len(FAMILIES), p=SHARES))]
        kind = str(self._rng.choice(kinds_among(family, self._names)))
        return kind, self._between(LENGTHS[kind])

    def _fault(self, kind: str, start: float, duration: float, vehicle: str) -> Fault:
        return Fault(
            kind=kind,
            start=float(np.clip(start, earliest_start(kind), self._last)),
            duration=duration,
            vehicles=self._named_vehicles(kind, vehicle),
            size=self._between(SIZES[kind]) if kind in SIZES else 0.0,
        )

    def _named_vehicles(self, kind: str, vehicle: str) -> Names:
        if KINDS[kind].whole_frame:
            return ()
        if kind != "swap":
            return (vehicle,)
        others = [name for name in self._names if name != vehicle]
        return tuple(sorted((vehicle, str(self._rng.choice(others))), key=self._names.index))

    def _between(self, bounds: tuple[float, float]) -> float:
        return bounds[0] + float(self._rng.beta(ARCSINE, ARCSINE)) * (bounds[1] - bounds[0])
