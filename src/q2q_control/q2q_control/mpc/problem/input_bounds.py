"""Bounds of the commanded acceleration of each axis from thrust, tilt and the least thrust.

    |u_x|, |u_y| <= side,   -FALL g <= u_z <= thrust / m (1 - 2 (q_x^2 + q_y^2)) - g

A thrust limit below the weight puts both bounds of z at the most it allows.
"""

from typing import NamedTuple

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import GRAVITY

FALL = 0.95
"""Largest downward acceleration over gravity [-]: some thrust is left to tilt."""


class AccelerationLimits(NamedTuple):
    """Largest accelerations of a level vehicle."""

    side: float
    """Of x and of y [m/s^2]."""
    thrust: float
    """Largest thrust over mass [m/s^2]."""


@compiled
def input_bounds(quat: Array, most: AccelerationLimits) -> tuple[Array, Array]:
    """Return the least and largest input [m/s^2], (n, 3) each, at attitudes (n, 4)."""
    low, high = np.empty((quat.shape[0], 3)), np.empty((quat.shape[0], 3))
    for v in range(quat.shape[0]):
        upright = 1.0 - 2.0 * (quat[v, 0] ** 2 + quat[v, 1] ** 2)
        high[v, 0], high[v, 1], high[v, 2] = most.side, most.side, most.thrust * upright - GRAVITY
        low[v, 0], low[v, 1], low[v, 2] = -most.side, -most.side, min(-FALL * GRAVITY, high[v, 2])
    return low, high


def stage_bounds(low: Array, high: Array, kept: Array) -> Array:
    """Return the largest input of each stage, (n, N, 3): on z less what it keeps (n, N), at least `low`."""
    bounds = np.repeat(high[:, None], kept.shape[1], axis=1)
    bounds[..., 2] = np.maximum(bounds[..., 2] - kept, low[:, None, 2])
    return bounds
