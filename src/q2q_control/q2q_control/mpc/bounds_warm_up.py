"""Warm-up ticks at which the solver meets its bounds, next to a vehicle of another controller."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from q2q_model.signals.layout import Signal
from q2q_model.signals.some_vehicles import of_vehicles
from q2q_model.signals.values import SwarmCommand, SwarmSetpoint, SwarmState

FAR_OFF = 10.0
"""Distance of the setpoints along each axis at which thrust and tilt reach their bounds [m]."""


def at_bounds(update: Callable[..., SwarmCommand]) -> Callable[..., SwarmCommand]:
    """Return `update` with setpoints far off, and none for the last vehicle: another controller flies it."""

    def far(state: SwarmState, setpoint: SwarmSetpoint, *downwash: Signal) -> SwarmCommand:
        rows = np.arange(len(setpoint.names) - 1)
        return update(state, of_vehicles(replace(setpoint, pos=setpoint.pos + FAR_OFF), rows), *downwash)

    return far
