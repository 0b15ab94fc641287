"""Rows of a recording in which a velocity setpoint is at its limit.

Differentiating a velocity setpoint at its limit gives no acceleration, although the controller is given one:
in up to half of the rows of a random walk.
"""

import numpy as np
from scipy.ndimage import maximum_filter1d

from q2q_model.signals.values import Array, Mask

LIMIT = 0.98
"""Share of its largest value from which a velocity setpoint counts as limited [-]."""
SLOWEST = 0.05
"""Smallest limit of a velocity setpoint [m/s]: a vehicle that is told to hover is not limited."""
AROUND = 3
"""Rows beside a limited one that count as limited too: the differences over them are wrong."""


def at_velocity_limit(vel: Array) -> Mask:
    """Return where velocity setpoints [m/s], (T, ...), are at the largest value of their column."""
    speed = np.abs(vel)
    at_limit = speed >= LIMIT * np.maximum(speed.max(axis=0), SLOWEST)
    return np.asarray(maximum_filter1d(at_limit, 2 * AROUND + 1, axis=0))
