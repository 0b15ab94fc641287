"""Example of a controller of one's own, to copy: proportional-derivative law, compensates the downwash.

scripts/fly table6_room --controller q2q_control.own_controller.pd_example:PdExample
"""

import numpy as np

from q2q_model.signals.values import (
    CommandStatus,
    Interference,
    SwarmCommand,
    SwarmSetpoint,
    SwarmState,
    predicted_eta,
    rows_by_name,
)
from q2q_model.vehicle.constants import GRAVITY, Vehicle

K_P = 10.0
"""Gain from position error to acceleration [1/s^2]."""
K_D = 5.0
"""Gain from velocity error to acceleration [1/s]."""
TILT_MAX = 0.4
"""[rad]"""


class PdExample:
    """Controller of all vehicles, one row for each."""

    def __init__(self, vehicle: Vehicle) -> None:
        """Take the vehicle type."""
        self._vehicle = vehicle

    def reset(self) -> None:
        """Do nothing: the law has no memory."""

    def update(
        self, state: SwarmState, setpoint: SwarmSetpoint, interference: Interference | None
    ) -> SwarmCommand:
        """Return thrust [N], roll and pitch [rad] for small angles; yaw is not controlled."""
        names = setpoint.names
        pos, vel = (rows_by_name(one, state.names, names, np.nan) for one in (state.pos, state.vel))
        acc = setpoint.acc + K_P * (setpoint.pos - pos) + K_D * (setpoint.vel - vel)
        acc -= predicted_eta(interference, names)
        return SwarmCommand(
            t=setpoint.t,
            names=names,
            thrust=np.clip(self._vehicle.mass * (GRAVITY + acc[:, 2]), 0.0, self._vehicle.thrust_max),
            roll=np.clip(-acc[:, 1] / GRAVITY, -TILT_MAX, TILT_MAX),
            pitch=np.clip(acc[:, 0] / GRAVITY, -TILT_MAX, TILT_MAX),
            yaw_rate=np.zeros(len(names)),
            status=np.full(len(names), CommandStatus.OK, dtype=np.uint8),
        )
