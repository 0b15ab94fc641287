"""Vehicles of other controllers, extrapolated at constant velocity."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.signals.values import KNOWN_NAMES, LOST, Array, Mask, Names, Rows, SwarmState

FAR = 1e6
"""Position of a vehicle without state [m]: out of everybody's reach."""


class Neighbours(NamedTuple):
    """Vehicles of other controllers, and their predicted motion over N stages."""

    names: Names
    pos: Array
    """Present positions [m], world, (n, 3)."""
    path: Array
    """[m], world, (n, N + 1, 3); far away if they have no state."""
    inputs: Array
    """Acceleration by thrust [m/s^2], world, (n, N, 3)."""
    spread: Array
    """Standard deviation of the horizontal position, each axis [m], (n,)."""


def at_constant_velocity(state: SwarmState, own: Names, times: Array) -> Neighbours:
    """Return the vehicles of `state` that are not `own`, extrapolated to the stages' `times` (N + 1,) [s].

    Vehicles without state are far away.
    """
    names, rows = _others(state.names, own)
    if not names:
        return _nobody(times.size)
    pos, lost = state.pos[rows], state.status[rows] == LOST
    path = _straight_on(pos, state.vel[rows], times - state.t, lost, rows)
    return Neighbours(names, pos, path, np.zeros((rows.size, times.size - 1, 3)), np.zeros(rows.size))


@lru_cache
def _nobody(stages: int) -> Neighbours:
    """Return no neighbours, at so many times."""
    none = np.zeros((0, 3))
    return Neighbours((), none, np.zeros((0, stages, 3)), np.zeros((0, stages - 1, 3)), np.zeros(0))


@lru_cache(maxsize=KNOWN_NAMES)
def _others(names: Names, own: Names) -> tuple[Names, Rows]:
    """Return those of `names` that are not `own`, and their rows."""
    rows = [row for row, name in enumerate(names) if name not in own]
    return tuple(names[row] for row in rows), np.array(rows, np.intp)


@compiled
def _straight_on(pos: Array, vel: Array, ahead: Array, lost: Mask, rows: Rows) -> Array:
    """Return paths (n, K, 3) at times `ahead` (K,) [s].

    A vehicle that is lost or not finite is put far away, in `pos` (n, 3) too.
    """
    path = np.empty((pos.shape[0], ahead.size, 3))
    for v in range(pos.shape[0]):
        known = not lost[v]
        for k in range(ahead.size):
            for axis in range(3):
                path[v, k, axis] = pos[v, axis] + vel[v, axis] * ahead[k]
                known = known and np.isfinite(path[v, k, axis])
        if not known:
            pos[v] = path[v] = -FAR * (1.0 + rows[v])
    return path
