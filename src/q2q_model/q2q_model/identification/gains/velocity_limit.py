"""Rows of a recording in which a velocity setpoint is at its limit.

Differentiating a velocity setpoint at its limit gives no acceleration, although the controller is given one:
in up to half of the rows of a random walk. An acceleration that was recorded is right there too, as at the
top speed of a sine or in a climb.
"""

import numpy as np
from scipy.ndimage import maximum_filter1d

from q2q_model.signals.values import Array, Mask

LIMIT = 0.98
"""Share of its largest value from which a velocity setpoint counts as limited [-]."""
SLOWEST = 0.05
"""Smallest limit of a velocity setpoint [m/s]: a vehicle that is commanded to hover is not limited."""
AROUND = 3
"""Rows next to a limited one that count as limited too: the differences over them are wrong."""

EQUAL = 1e-7
"""Share of the largest acceleration within which differences are equal to those that were taken before stamps
were rounded to nanoseconds [-]; differences over 20 ms miss 6e-6 of an acceleration of 0.1 Hz."""
LOST = 1.5
"""Step from which a tick is missing, and differences over it are others [median steps]."""


def is_differentiated(t: Array, vel: Array, acc: Array) -> bool:
    """Return whether accelerations are the central differences of velocities, both (T, n), at ticks t (T,).

    Only ticks whose neighbours are there are compared; without one, they are not.
    """
    steps = np.diff(t)
    near = steps < LOST * np.median(steps)
    inner = near[1:] & near[:-1]
    missed = np.abs(np.gradient(vel, t, axis=0) - acc)[1:-1][inner]
    known = np.isfinite(missed)
    largest = np.nanmax(np.abs(acc), initial=0.0)
    return bool(known.any() and (missed[known] <= EQUAL * largest).all())


def at_velocity_limit(vel: Array) -> Mask:
    """Return where velocity setpoints [m/s], (T, ...), are at the largest value of their column."""
    speed = np.abs(vel)
    at_limit = speed >= LIMIT * np.maximum(speed.max(axis=0), SLOWEST)
    return np.asarray(maximum_filter1d(at_limit, 2 * AROUND + 1, axis=0))
