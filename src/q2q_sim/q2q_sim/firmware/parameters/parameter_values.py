"""Parameter values of one vehicle, set by clients and read by the firmware."""

import numpy as np

from q2q_model.signals.values import Array
from q2q_sim.firmware.motors.airframe import Airframe
from q2q_sim.firmware.parameters.parameter_table import GAINS, IDLE_PWM, TABLE, FirmwareValue

STIFF = ("kp_xy", "kd_xy", "ki_xy", "kp_z", "kd_z", "ki_z")
"""Mellinger gains in N/m, N s/m, N/(m s)."""


def defaults_of(airframe: Airframe, *, auto_arming: bool) -> dict[str, FirmwareValue]:
    """Return the initial value of every parameter in the build for an airframe."""
    values = {one.name: one.default for one in TABLE}
    for name in STIFF:
        values[f"ctrlMel.{name}"] *= airframe.stiffness_share
    values["ctrlMel.kd_omega_rp"] *= airframe.share_lag
    values["ctrlMel.mass"] = airframe.mass
    values["ctrlMel.massThrust"] = airframe.pwm_per_newton
    values["powerDist.idleThrust"] = 0 if auto_arming else IDLE_PWM
    return {name: _as_float32(value) for name, value in values.items()}


class Parameters:
    """Parameter values; `changes` counts writes and resets, so that readers can cache derived values."""

    def __init__(self, airframe: Airframe, *, auto_arming: bool = True) -> None:
        self._defaults = defaults_of(airframe, auto_arming=auto_arming)
        self._values = dict(self._defaults)
        self.changes = 0

    def __getitem__(self, name: str) -> FirmwareValue:
        """Return the value of `group.name`."""
        return self._values[name]

    def set(self, name: str, value: FirmwareValue) -> None:
        """Set `group.name`."""
        self._values[name] = _as_float32(value)
        self.changes += 1

    def reset(self) -> None:
        """Set every parameter to its initial value."""
        self._values = dict(self._defaults)
        self.changes += 1

    def default(self, name: str) -> FirmwareValue:
        """Return the initial value."""
        return self._defaults[name]

    def flag(self, name: str) -> bool:
        """Return whether `group.name` is nonzero."""
        return self._values[name] != 0

    def gains(self) -> Array:
        """Return the row of the compiled controllers, (columns.GAIN_WIDTH,)."""
        row = [float(self._values[name]) for name in GAINS]
        return np.array([*row, float(self._values["stabilizer.controller"])])


def _as_float32(value: FirmwareValue) -> FirmwareValue:
    """Return a value as the vehicle stores it: floats have 32 bits."""
    return value if isinstance(value, int) else float(np.float32(value))
