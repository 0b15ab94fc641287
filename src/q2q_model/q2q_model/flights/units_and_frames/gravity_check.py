"""Doubt whether the vertical accelerations of a table are in m/s^2 and without gravity.

Their mean is a difference of velocities over the time between, near 0 in every flight of some seconds: a
median near 1 or GRAVITY, of either sign, is an accelerometer's, which reads gravity, in units of g or in
m/s^2.
"""

import numpy as np

from q2q_model.counted import listed
from q2q_model.signals.values import Array, Names
from q2q_model.vehicle.constants import GRAVITY

WITHIN = 0.15
"""Deviation from 1 g of a median that is taken for gravity [g]: tilts, and biases of accelerometers."""
LEAST_S = 3.0
"""Shortest flight that is doubted [s]: with 1 m/s^2 for half of it, it would change its speed by 1.5 m/s."""


def gravity_note(t: Array, names: Names, az: Array) -> str:
    """Return which vehicles' az, (T, n), seem to have gravity in them at t (T,) [s]; empty for none."""
    found = {}
    for name, column in zip(names, az.T, strict=True):
        known = np.isfinite(column)
        if known.any() and np.ptp(t[known]) >= LEAST_S:
            found[name] = float(np.median(column[known]))
    doubted = [f"{median:.2f} m/s^2 ({name})" for name, median in found.items() if _is_gravity(abs(median))]
    if not doubted:
        return ""
    return f"az seems to include gravity, in g or m/s^2: its median must be near 0, but is {listed(doubted)}"


def _is_gravity(reading: float) -> bool:
    return any(abs(reading - gravity) < WITHIN * gravity for gravity in (1.0, GRAVITY))
