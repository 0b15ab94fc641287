"""Bound the commanded acceleration of each axis by thrust, tilt and the weight that a vehicle may drop.

    |u_x|, |u_y| <= side,   -FALL g <= u_z <= lift (1 - 2 (q_x^2 + q_y^2)) - g

A bound on thrust below the weight puts both bounds of z where it allows.
"""

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import GRAVITY

FALL = 0.95
"""Share of its weight that a vehicle may drop at most [-]: some thrust is left to tilt."""


@compiled
def bounds_of(quat: Array, most: tuple[float, float]) -> tuple[Array, Array]:
    """Return the least and largest input [m/s^2], (n, 3) each: attitudes (n, 4), (side, thrust over mass)."""
    low, high = np.empty((quat.shape[0], 3)), np.empty((quat.shape[0], 3))
    side, lift = most
    for v in range(quat.shape[0]):
        upright = 1.0 - 2.0 * (quat[v, 0] ** 2 + quat[v, 1] ** 2)
        high[v, 0], high[v, 1], high[v, 2] = side, side, lift * upright - GRAVITY
        low[v, 0], low[v, 1], low[v, 2] = -side, -side, min(-FALL * GRAVITY, high[v, 2])
    return low, high
