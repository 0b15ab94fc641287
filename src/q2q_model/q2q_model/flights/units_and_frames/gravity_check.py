"""Doubt whether the vertical accelerations of a table are in m/s^2 and without gravity.

Their mean is a difference of velocities over the time between, near 0 in every flight of some seconds: a
median near 1 or GRAVITY is an accelerometer's, which reads gravity, in units of g or in m/s^2.
"""

import numpy as np

from q2q_model.signals.values import Array, Names
from q2q_model.vehicle.constants import GRAVITY

WITHIN = 0.15
"""Deviation from 1 g of a median that is taken for gravity [g]: tilts, and biases of accelerometers."""


def gravity_note(names: Names, az: Array) -> str:
    """Return which vehicles' az, (T, n), seem to have gravity in them, and how to map it; empty for none."""
    known = [column[np.isfinite(column)] for column in az.T]
    found = {name: float(np.median(one)) for name, one in zip(names, known, strict=True) if one.size}
    for gravity, unit, change in ((1.0, "g", f"scale: {GRAVITY:g}, "), (GRAVITY, "m/s^2", "")):
        for name, median in found.items():
            if abs(median - gravity) < WITHIN * gravity:
                return (
                    f"az of {name} is {median:.2f} in the median, 0 is expected: if that is gravity, in "
                    f"{unit}, a column map takes it off (--columns): az: {{from: az, {change}offset: "
                    f"-{GRAVITY:g}}}"
                )
    return ""
