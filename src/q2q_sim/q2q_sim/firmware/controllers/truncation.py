"""Conversion of floats to integers as on the vehicle's processor.

Source: Arm Architecture Reference Manual ARMv7-M, VCVT: rounds towards zero, saturates, and converts NaN
to 0.
"""

import math

from q2q_model.compiled import compiled

INT16_MAX, INT32_MAX = 32767.0, 2147483647.0


@compiled
def truncate(number: float, limit: float) -> float:
    """Return a number rounded towards zero, within +-limit; 0 for NaN."""
    if math.isnan(number):
        return 0.0
    return float(math.trunc(min(max(number, -limit), limit)))
