"""Drop the fraction of a number as the vehicle's processor does where the firmware stores it whole.

Source: Arm Architecture Reference Manual ARMv7-M, VCVT: rounds to zero, saturates, and makes 0 of what is no
number.
"""

import math

from q2q_model.compiled import compiled

INT16_MAX, INT32_MAX = 32767.0, 2147483647.0


def _whole(number: float, limit: float) -> float:
    """Return a number without its fraction, within a limit; 0 for what is no number."""
    if math.isnan(number):
        return 0.0
    return float(math.trunc(min(max(number, -limit), limit)))


whole = compiled(_whole)
