"""Random situations of pairs, to be solved by the receding horizon, and random encounters, to be flown.

A second vehicle passes 0.25 to 1 m above or below the first, straight or curved, fast or so slowly that it
stays. Both may move, both are off their references, and other accelerations act too: a disturbance, a
reference's acceleration, the downwash of a third vehicle. Encounters are longer: a pass, or a stop above the
other, of either vehicle.
"""

from dataclasses import dataclass

import numpy as np

from q2q_control.explicit_mpc.features import STAGES
from q2q_model.signals.values import Array

Range = tuple[float, float]

GAPS: Range = (0.25, 1.0)
"""Height differences of a pair [m]."""
SPEEDS: Range = (0.02, 1.0)
"""Speeds of encounters [m/s], log-uniform."""
DWELLS: Range = (1.0, 4.0)
"""Approximate durations of an encounter's stop [s]."""


@dataclass(frozen=True, slots=True)
class Situations:
    """K situations of a pair, N stages ahead."""

    states: Array
    """Height error [m], climb error [m/s], acceleration by thrust [m/s^2], (K, 2, 3)."""
    paths: Array
    """References [m], world, (K, 2, N + 1, 3)."""
    extra: Array
    """Acceleration besides the downwash between the two [m/s^2], (K, 2, N)."""


@dataclass(frozen=True, slots=True)
class Encounters:
    """E flights of a pair, each with a horizon beyond its end."""

    paths: Array
    """References [m], world, (E, 2, M + N + 1, 3)."""
    extra: Array
    """[m/s^2], (E, 2, M + N)."""

    @property
    def length(self) -> int:
        """Return M, the number of stages flown."""
        return int(self.extra.shape[2]) - STAGES

    def ahead(self, states: Array, k: int) -> Situations:
        """Return the situations at stage k in `states` (E, 2, 3)."""
        return Situations(states, self.paths[:, :, k : k + STAGES + 1], self.extra[:, :, k : k + STAGES])


def random_situations(count: int, step: float, rng: np.random.Generator) -> Situations:
    """Return situations with stages of `step` [s]."""
    k, t = count, np.arange(STAGES + 1)[:, None] * step
    turn = _turns(rng.uniform(0.0, 2.0 * np.pi, k))
    start = np.zeros((3, k, 2, 3))  # position, velocity, acceleration
    slow = rng.choice([0.03, 0.1, 0.3, 1.0], (k, 1))
    across = rng.normal(size=(3, k, 2)) * [[[0.1, 0.3]], [[0.03, 0.25]], [[0.005, 0.04]]]
    across[1:] *= slow
    start[:, :, 1, :2] = np.einsum("kab,dkb->dka", turn, across)  # second vehicle, turned
    start[0, :, 1, 2] = rng.uniform(*GAPS, k) * rng.choice([-1.0, 1.0], k)
    start[1, :, 1, 2] = rng.normal(size=k) * 0.1 * rng.choice([0.0, 0.0, 1.0], k)
    start[1, :, :, :2] += (rng.normal(size=(k, 2)) * rng.choice([0.0, 0.2], (k, 1)))[:, None]
    pos, vel, acc = start[:, :, :, None]
    spread = rng.choice([0.2, 1.0], (k, 1, 1))
    extra = _extra(k, step, rng)
    states = rng.normal(size=(k, 2, 3)) * [0.04, 0.06, 0.2] * spread
    states[..., 2] -= extra[..., 0]
    return Situations(states, pos + vel * t + acc * t**2 / 2.0, extra)


def random_encounters(count: int, length: int, step: float, rng: np.random.Generator) -> Encounters:
    """Return encounters of `length` stages of `step` [s]; a third of them with a disturbance."""
    stages = length + STAGES
    tau = np.arange(stages + 1) * step - rng.uniform(1.0, length * step, count)[:, None]
    speed = (SPEEDS[0] * (SPEEDS[1] / SPEEDS[0]) ** rng.random(count))[:, None]
    dwell = rng.uniform(*DWELLS, count)[:, None]
    stops = rng.random((count, 1)) < 0.4
    along = np.where(stops, speed * tau**3 / (tau**2 + dwell**2), speed * tau)
    aside = np.broadcast_to(rng.normal(size=(count, 1)) * 0.06, along.shape)
    moved = np.einsum(
        "kab,ktb->kta", _turns(rng.uniform(0.0, 2.0 * np.pi, count)), np.stack([along, aside], -1)
    )
    paths = np.zeros((count, 2, stages + 1, 3))
    second = rng.random(count) < 0.5  # moves, else the first does
    paths[second, 1, :, :2], paths[~second, 0, :, :2] = moved[second], -moved[~second]
    paths[:, 1, :, 2] = (rng.uniform(*GAPS, count) * rng.choice([-1.0, 1.0], count))[:, None]
    steady = rng.normal(size=(count, 2, 1)) * rng.choice([0.0, 0.0, 0.05], (count, 1, 1))
    return Encounters(paths, np.repeat(steady, stages, axis=2))


def _turns(angle: Array) -> Array:
    """Return rotations, (K, 2, 2)."""
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c, -s, s, c], axis=-1).reshape(-1, 2, 2)


def _extra(count: int, step: float, rng: np.random.Generator) -> Array:
    """Return a constant and a transient acceleration of each vehicle, (K, 2, N)."""
    middle = (np.arange(STAGES) + 0.5) * step
    steady = rng.normal(size=(count, 2, 1)) * 0.15 * rng.choice([0.0, 0.3, 1.0], (count, 1, 1))
    height = rng.normal(size=(count, 2, 1)) * 0.3 * rng.choice([0.0, 0.0, 1.0], (count, 2, 1))
    when, wide = rng.uniform(-0.5, 2.5, (count, 2, 1)), rng.uniform(0.1, 0.8, (count, 2, 1))
    return np.asarray(steady + height * np.exp(-((middle - when) ** 2) / (2.0 * wide**2)))
