"""Vertical acceleration of vehicles that is not due to their thrust, from accelerometer and command.

    y_i = (R f_body)_z - lagged(U1) b_z / m

while the rotors carry the vehicle (q2q_model.downwash.correction.carried_by_rotors); otherwise y would be
what the ground carries.

| symbol | name | meaning [unit] |
|---|---|---|
| f_body | specific_force_body | accelerometer [m/s^2] |
| U1 | thrust | commanded [N]; the rotors follow with the vehicle's lag, from tick to tick the later command |
| b | | body z |
"""

import numpy as np

from q2q_model.downwash.correction.carried_by_rotors import is_carried
from q2q_model.geometry.rotations import UP, rotate
from q2q_model.signals.values import Array, Names, SwarmCommand, SwarmImu, SwarmState, rows_by_name
from q2q_model.vehicle.constants import Vehicle

LONGEST_STEP = 0.1
"""Time step beyond which thrust is assumed to have settled, as where time goes back [s]."""


class MeasuredPush:
    """Measurement of pushes, with the thrust that the rotors give by now."""

    def __init__(self, vehicle: Vehicle) -> None:
        self._vehicle = vehicle
        self.reset()

    def reset(self) -> None:
        """Forget the thrust."""
        self._names: Names = ()
        self._thrust: Array = np.zeros(0)
        self._t = -np.inf

    def update(self, state: SwarmState, command: SwarmCommand, imu: SwarmImu) -> Array:
        """Return y [m/s^2], (n,), as in `state`; NaN where it cannot be measured."""
        passed, self._t = state.t - self._t, state.t
        dt = passed if 0.0 <= passed < LONGEST_STEP else LONGEST_STEP
        if state.names != self._names:
            self._thrust = rows_by_name(self._thrust, self._names, state.names, np.nan)
            self._names = state.names
        commanded = rows_by_name(command.thrust, command.names, state.names, np.nan)
        keep = np.exp(-dt / self._vehicle.thrust_lag) if self._vehicle.thrust_lag > 0.0 else 0.0
        before = np.where(np.isfinite(self._thrust), self._thrust, commanded)
        settled = keep * before + (1.0 - keep) * commanded
        self._thrust = np.where(np.isfinite(commanded), settled, before)
        felt = rows_by_name(imu.specific_force_body, imu.names, state.names, np.nan)
        force = rotate(state.quat, felt)[:, 2]
        body_z = rotate(state.quat, UP)[:, 2]
        carried = is_carried(self._thrust, self._vehicle)
        return np.where(carried, force - self._thrust * body_z / self._vehicle.mass, np.nan)
