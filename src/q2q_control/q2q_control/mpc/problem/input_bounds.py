"""Bounds of the commanded acceleration of each axis from thrust, tilt and the least thrust.

    |u_x|, |u_y| <= side,   -FALL g <= u_z <= thrust / m (1 - 2 (q_x^2 + q_y^2)) - g

A thrust limit below the weight puts both bounds of z at the most it allows.
"""

from typing import NamedTuple

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array
from q2q_model.vehicle.attitude_limits import LEAST_THRUST
from q2q_model.vehicle.constants import GRAVITY

FALL = 1.0 - LEAST_THRUST
"""Largest downward acceleration over gravity [-]."""


class AccelerationLimits(NamedTuple):
    """Largest accelerations of a level vehicle."""

    side: float
    """Of x and of y [m/s^2]."""
    thrust: float
    """Largest thrust over mass [m/s^2]."""


def level_bounds(thrust: float) -> tuple[float, float]:
    """Return the least and largest vertical input of a level vehicle [m/s^2] of this thrust over mass."""
    high = thrust - GRAVITY
    return min(-FALL * GRAVITY, high), high


@compiled
def input_bounds(quat: Array, limits: tuple[float, float], reserve: Array) -> tuple[Array, Array]:
    """Return the least input (n, 3) and the largest of each stage (n, N, 3) [m/s^2] at attitudes (n, 4).

    On z, the largest input of a stage is lowered by its `reserve` (n, N) [m/s^2], down to the least one.
    `limits` are the fields of AccelerationLimits.
    """
    most = AccelerationLimits(*limits)
    n, stages = reserve.shape
    low, high = np.empty((n, 3)), np.empty((n, stages, 3))
    for v in range(n):
        upright = 1.0 - 2.0 * (quat[v, 0] ** 2 + quat[v, 1] ** 2)
        top = most.thrust * upright - GRAVITY
        low[v, 0], low[v, 1], low[v, 2] = -most.side, -most.side, min(-FALL * GRAVITY, top)
        for k in range(stages):
            high[v, k, 0], high[v, k, 1] = most.side, most.side
            high[v, k, 2] = max(top - reserve[v, k], low[v, 2])
    return low, high
