"""Estimate position, velocity and the acceleration that nothing explains, from positions and known thrust.

    r+ = r + h v + h^2/2 (a + d),  v+ = v + h (a + d),  d+ = d        a: by thrust, and by the predicted
    downwash r, v, d += L (r_measured - r)

L puts two poles at exp(-w_s h), for position and velocity, and one at exp(-w_d h) (Luenberger): what a wrong
downwash model, a weak battery or moving air push goes into d within some 3 / w_d, while position and velocity
follow their measurements sooner. With the poles' sums s1, s2, s3 (of one, two, three of them):

    L = (l1, l2 / h, l3 / h^2),  l1 = 1 - s3,  l3 = 1 - s1 + s2 - s3,  l2 = 3 - s1 - l1 - l3 / 2

Thrust enters as it was commanded, limits included, so nothing winds up while a limit cuts. Subtracted from
the command, d leaves no offset behind. The velocity knows the thrust and is less late than one filtered from
positions alone.

| symbol | name | meaning [unit] |
|---|---|---|
| r v | pos vel | estimates [m], [m/s], world, (n, 3) |
| d | disturbance | unexplained acceleration [m/s^2], world, (n, 3) |
| w_s w_d | state_bandwidth, disturbance_bandwidth | [rad/s] |
"""

import math
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array, Names, index_of

GAP_MAX = 0.1
"""Beyond this time between ticks [s] the estimate starts anew at the measurement."""


@dataclass(frozen=True, slots=True)
class Measurement:
    """Measurements of the vehicles at one tick."""

    t: float
    """Stamp of the tick [s]."""
    names: Names
    pos: Array
    """[m], world, (n, 3)."""
    vel: Array
    """[m/s], world, (n, 3); it only starts a vehicle."""
    acc: Array
    """By thrust and predicted downwash, mean since the last tick [m/s^2], world, (n, 3)."""
    fresh: NDArray[np.bool_]
    """Rows whose position was measured at this tick, (n,); the others follow the model."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """Estimated state and disturbance of every vehicle."""

    pos: Array
    """[m], world, (n, 3)."""
    vel: Array
    """[m/s], world, (n, 3)."""
    disturbance: Array
    """[m/s^2], world, (n, 3)."""


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

    def update(self, seen: Measurement) -> Estimate:
        """Return the estimates at the measurement's time, row by row."""
        if seen.names != self._names:
            self._reorder(seen.names)
        step = seen.t - self._t
        self._t = seen.t
        if not 0.0 < step <= GAP_MAX:
            self._known[:] = False
            step = GAP_MAX  # of no consequence: no row is known
        gain = observer_gain(self._poles[0], self._poles[1], step)
        old = self.estimate
        moved = correct(
            (old.pos, old.vel, old.disturbance),
            (seen.pos, seen.vel, seen.acc, seen.fresh),
            self._known,
            (*gain, step, self._max),
        )
        self.estimate = Estimate(*moved)
        self._known |= seen.fresh
        return self.estimate

    def _reorder(self, names: Names) -> None:
        rows = index_of(names, self._names)
        known = np.append(self._known, False)
        pad = np.zeros((1, 3))
        old = self.estimate
        self.estimate = replace(
            old,
            pos=np.vstack([old.pos, pad])[rows],
            vel=np.vstack([old.vel, pad])[rows],
            disturbance=np.vstack([old.disturbance, pad])[rows],
        )
        self._known, self._names = known[rows], names


@lru_cache(maxsize=64)
def observer_gain(state: float, disturbance: float, step: float) -> tuple[float, float, float]:
    """Return L [-, 1/s, 1/s^2] of a step [s] for poles at `state`, twice, and `disturbance` [rad/s]."""
    fast, slow = math.exp(-state * step), math.exp(-disturbance * step)
    l1 = 1.0 - fast * fast * slow
    l3 = (1.0 - fast) ** 2 * (1.0 - slow)  # 1 - s1 + s2 - s3
    l2 = 3.0 - (2.0 * fast + slow) - l1 - 0.5 * l3
    return l1, l2 / step, l3 / step**2


@compiled
def correct(
    old: tuple[Array, Array, Array],
    seen: tuple[Array, Array, Array, NDArray[np.bool_]],
    known: NDArray[np.bool_],
    rule: tuple[float, float, float, float, float],
) -> tuple[Array, Array, Array]:
    """Return pos, vel, disturbance (n, 3) each.

    Args:
        old: the last ones.
        seen: pos, vel, acc, fresh of a Measurement.
        known: rows with an estimate, (n,).
        rule: l1, l2 / h, l3 / h^2, h, largest d.
    """
    l1, l2, l3, step, most = rule
    old_pos, old_vel, old_d = old
    seen_pos, seen_vel, acc, fresh = seen
    n = known.size
    pos, vel, d = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3))
    for v in range(n):
        for axis in range(3):
            if not known[v]:
                pos[v, axis], vel[v, axis], d[v, axis] = seen_pos[v, axis], seen_vel[v, axis], 0.0
                continue
            whole = acc[v, axis] + old_d[v, axis]
            ahead = old_pos[v, axis] + step * old_vel[v, axis] + 0.5 * step * step * whole
            off = seen_pos[v, axis] - ahead if fresh[v] else 0.0
            pos[v, axis] = ahead + l1 * off
            vel[v, axis] = old_vel[v, axis] + step * whole + l2 * off
            d[v, axis] = min(max(old_d[v, axis] + l3 * off, -most), most)
    return pos, vel, d
