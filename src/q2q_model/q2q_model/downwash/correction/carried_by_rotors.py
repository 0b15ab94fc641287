"""Ticks in which rotors carry their vehicle, so that what else pushes it can be measured.

A vehicle on the ground is carried by it, and an accelerometer feels that force as a push of up to the weight.
With motors off, or nearly in free fall, nothing is measured; nothing is forgotten either.
"""

import numpy as np

from q2q_model.signals.values import Array, Mask
from q2q_model.vehicle.constants import Vehicle

CARRIED_SHARE = 0.3
"""Thrust over nominal weight from which on pushes are measured [-].

Vehicles that hover from 0.5 on are allowed, and in public flights the lagged thrust of a Crazyflie 2.0 in the
air is never below 0.71.
"""


def is_carried(thrust: Array, vehicle: Vehicle) -> Mask:
    """Return which vehicles their rotors carry, (n,), by their thrust now [N], (n,); not where NaN."""
    return np.asarray(thrust >= CARRIED_SHARE * vehicle.hover_thrust)
