"""Luenberger observer of position, velocity and disturbance, from measured positions and known thrust.

    r+ = r + h v + h^2/2 (a + d),  v+ = v + h (a + d),  d+ = d        a: by thrust, and by the predicted
    downwash r, v, d += L (r_measured - r)

L places two poles at exp(-w_s h), for position and velocity, and one at exp(-w_d h): the effects of a wrong
downwash model, a weak battery or moving air appear in d within about 3 / w_d, while position and velocity
follow their measurements faster. With s1, s2, s3 the elementary symmetric polynomials of the poles:

    L = (l1, l2 / h, l3 / h^2),  l1 = 1 - s3,  l3 = 1 - s1 + s2 - s3,  l2 = 3 - s1 - l1 - l3 / 2

Thrust enters as commanded, limits included, so there is no wind-up at a limit. Subtracting d from the command
removes the steady-state error. The velocity uses the thrust and so lags less than one filtered from positions
alone.

A position further than JUMP from its estimate is that of a track that was lost or displaced, not the work of
a disturbance: position and velocity restart at the measurement, the disturbance stays.

| symbol | name | meaning [unit] |
|---|---|---|
| r v | pos vel | estimates [m], [m/s], world, (n, 3) |
| d | disturbance | unexplained acceleration [m/s^2], world, (n, 3) |
| w_s w_d | state_bandwidth, disturbance_bandwidth | [rad/s] |
"""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array, Names, rows_by_name

JUMP = 0.1
"""Largest error of an estimated position that a disturbance may have made [m]: 3 m/s^2 do in 0.26 s."""
GAP_MAX = 0.1
"""Time between ticks [s] beyond which the estimate restarts at the measurement."""


class MeasuredRows(NamedTuple):
    """What is measured of vehicles at one tick."""

    pos: Array
    """[m], world, (n, 3)."""
    vel: Array
    """[m/s], world, (n, 3); used where an estimate starts."""
    acc: Array
    """By thrust and predicted downwash, mean since the last tick [m/s^2], world, (n, 3)."""
    fresh: NDArray[np.bool_]
    """Rows whose position was measured at this tick, (n,); the others follow the model."""


PlainRows = tuple[Array, Array, Array, NDArray[np.bool_]]
"""Fields of MeasuredRows, which numba takes from Python in less than half the time."""


@dataclass(frozen=True, slots=True)
class Measurement:
    """Measurements of named vehicles at one tick."""

    t: float
    """Stamp of the tick [s]."""
    names: Names
    rows: MeasuredRows


class Estimate(NamedTuple):
    """Estimated state and disturbance of every vehicle."""

    pos: Array
    """[m], world, (n, 3)."""
    vel: Array
    """[m/s], world, (n, 3)."""
    disturbance: Array
    """[m/s^2], world, (n, 3)."""


PlainEstimate = tuple[Array, Array, Array]
"""Fields of an Estimate."""


class ObserverGain(NamedTuple):
    """L of one step."""

    pos: float
    """[-]"""
    vel: float
    """[1/s]"""
    disturbance: float
    """[1/s^2]"""
    step: float
    """h [s]."""


PlainGain = tuple[float, float, float, float]
"""Fields of an ObserverGain."""


class DisturbanceObserver:
    """Estimates of named vehicles."""

    def __init__(self, state_bandwidth: float, disturbance_bandwidth: float, disturbance_max: float) -> None:
        """Place the poles [rad/s]; |d| stays within disturbance_max [m/s^2]."""
        self._poles = (state_bandwidth, disturbance_bandwidth)
        self._max = disturbance_max
        self.reset()

    def reset(self) -> None:
        """Forget all estimates."""
        self._names: Names = ()
        self._t = -np.inf
        self._known = np.zeros(0, np.bool_)
        self.estimate = Estimate(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 3)))

    def update(self, measured: Measurement) -> Estimate:
        """Return the estimates at the measurement's time, row by row."""
        if measured.names != self._names:
            self._reorder(measured.names)
        step = measured.t - self._t
        self._t = measured.t
        if not 0.0 < step <= GAP_MAX:
            self._known[:] = False
            step = GAP_MAX  # of no consequence: no row is known
        gain = observer_gain(self._poles[0], self._poles[1], step)
        old, rows = (*self.estimate,), (*measured.rows,)
        self.estimate = Estimate(*correct_estimate(old, rows, self._known, gain, self._max))
        self._known |= measured.rows.fresh
        return self.estimate

    def _reorder(self, names: Names) -> None:
        have, old = self._names, self.estimate
        self.estimate = Estimate(
            pos=rows_by_name(old.pos, have, names),
            vel=rows_by_name(old.vel, have, names),
            disturbance=rows_by_name(old.disturbance, have, names),
        )
        self._known, self._names = rows_by_name(self._known, have, names), names


@lru_cache(maxsize=64)
def observer_gain(state: float, disturbance: float, step: float) -> PlainGain:
    """Return L of a step [s] for poles at `state`, twice, and `disturbance` [rad/s]."""
    fast, slow = math.exp(-state * step), math.exp(-disturbance * step)
    l1 = 1.0 - fast * fast * slow
    l3 = (1.0 - fast) ** 2 * (1.0 - slow)  # 1 - s1 + s2 - s3
    l2 = 3.0 - (2.0 * fast + slow) - l1 - 0.5 * l3
    return (*ObserverGain(l1, l2 / step, l3 / step**2, step),)


@compiled
def correct_estimate(
    before: PlainEstimate, rows: PlainRows, known: NDArray[np.bool_], gains: PlainGain, most: float
) -> PlainEstimate:
    """Return the estimate one step later; rows that are not `known` (n,) start at the measurement.

    `most` bounds the disturbance [m/s^2].
    """
    old, measured, gain = Estimate(*before), MeasuredRows(*rows), ObserverGain(*gains)
    n, h = known.size, gain.step
    pos, vel, d = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3))
    for v in range(n):
        jumped = known[v] and measured.fresh[v] and _has_jumped(old, measured, v, h)
        for axis in range(3):
            if jumped or not known[v]:
                pos[v, axis], vel[v, axis] = measured.pos[v, axis], measured.vel[v, axis]
                d[v, axis] = old.disturbance[v, axis] if jumped else 0.0
                continue
            acc = measured.acc[v, axis] + old.disturbance[v, axis]
            ahead = old.pos[v, axis] + h * old.vel[v, axis] + 0.5 * h * h * acc
            error = measured.pos[v, axis] - ahead if measured.fresh[v] else 0.0
            pos[v, axis] = ahead + gain.pos * error
            vel[v, axis] = old.vel[v, axis] + h * acc + gain.vel * error
            d[v, axis] = min(max(old.disturbance[v, axis] + gain.disturbance * error, -most), most)
    return pos, vel, d


@compiled
def _has_jumped(old: Estimate, measured: MeasuredRows, v: int, step: float) -> bool:
    """Return whether vehicle v is measured further than JUMP from where its velocity leads in a step [s]."""
    squared = 0.0
    for axis in range(3):
        squared += (measured.pos[v, axis] - old.pos[v, axis] - step * old.vel[v, axis]) ** 2
    return bool(squared > JUMP * JUMP)
