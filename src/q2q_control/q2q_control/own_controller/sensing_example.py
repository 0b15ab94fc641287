"""Example of a controller of one's own with inertial sensors, to copy: it compensates the measured air.

    scripts/fly stack3 --air room --controller q2q_control.own_controller.sensing_example:SensingExample

Along the thrust, an accelerometer shows U1 / m + d, with U1 after the lag of the rotors and the acceleration
d by the air. Low-passed, d takes the place of the predicted downwash.
"""

from dataclasses import replace

import numpy as np

from q2q_control.own_controller.pd_example import PdExample
from q2q_model.signals.stamps import TICK_S
from q2q_model.signals.values import (
    Array,
    Interference,
    Names,
    SwarmCommand,
    SwarmImu,
    SwarmSetpoint,
    SwarmState,
    rows_by_name,
)
from q2q_model.vehicle.constants import Vehicle

TIME = 0.15
"""Time constant of the filter of d [s]: twice the thrust lag."""


class SensingExample(PdExample):
    """Controller of all vehicles, which keeps the d of each."""

    def __init__(self, vehicle: Vehicle) -> None:
        """Take the vehicle type."""
        super().__init__(vehicle)
        self._mass, self._thrust_max, self._lag = vehicle.mass, vehicle.thrust_max, vehicle.thrust_lag
        self.reset()

    def reset(self) -> None:
        """Forget the air."""
        self._names: Names = ()
        self._air: Array = np.zeros(0)
        self._lagged: Array = np.zeros(0)

    def update(self, state: SwarmState, setpoint: SwarmSetpoint, _: Interference | None) -> SwarmCommand:
        """Return the command of the law, less the thrust that the air gives."""
        command = super().update(state, setpoint, None)
        self._air = rows_by_name(self._air, self._names, command.names)
        thrust = np.clip(command.thrust - self._mass * self._air, 0.0, self._thrust_max)
        given = np.nan_to_num(thrust)
        before = rows_by_name(self._lagged, self._names, command.names, given)
        self._lagged = before + TICK_S / (TICK_S + self._lag) * (given - before)
        self._names = command.names
        return replace(command, thrust=thrust)

    def sense(self, imu: SwarmImu) -> None:
        """Filter d of the tick's accelerometers."""
        felt = rows_by_name(imu.specific_force_body[:, 2], imu.names, self._names, np.nan)
        beyond = felt - self._lagged / self._mass
        self._air = self._air + TICK_S / TIME * np.nan_to_num(beyond - self._air)
