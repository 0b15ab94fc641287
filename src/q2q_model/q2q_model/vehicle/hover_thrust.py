"""Consistency of our hover command with the vehicle's own hover parameters.

The RPYT setpoint at hover is PWM_c = 65535 m g / f_full by the table of vehicle and firmware. The onboard
Mellinger controller, with the parameters read from the vehicle, uses

    PWM_o = ctrlMel.massThrust * ctrlMel.mass * g

A ratio PWM_c / PWM_o far from 1 indicates a wrong vehicle, a wrong firmware or an unset mass. massThrust is
132000 on every stock build, and 65535 / f_full would match. On current firmware it is 3 % below that, but
60 % above it on a Brushless and 45 % with the upgrade kit, where it must be set.
"""

import math
from dataclasses import dataclass

from q2q_model.vehicle.constants import GRAVITY, Vehicle
from q2q_model.vehicle.thrust_map import PWM_FULL

OWN_PARAMETERS = ("ctrlMel.mass", "ctrlMel.massThrust")
"""Firmware parameters to read from the vehicle."""


@dataclass(frozen=True, slots=True)
class OwnHover:
    """Firmware parameters that determine the PWM at hover."""

    mass: float
    """ctrlMel.mass [kg]."""
    mass_thrust: float
    """ctrlMel.massThrust [1/N]."""

    @property
    def pwm(self) -> float:
        """Return PWM_o."""
        return self.mass_thrust * self.mass * GRAVITY


def hover_pwm(vehicle: Vehicle) -> float:
    """Return PWM_c, the PWM of each motor in an RPYT setpoint at hover."""
    return PWM_FULL * vehicle.hover_thrust / vehicle.full_pwm_thrust


def hover_ratio(vehicle: Vehicle, own: OwnHover) -> float:
    """Return PWM_c / PWM_o; infinite if the vehicle's own parameters give no thrust."""
    return hover_pwm(vehicle) / own.pwm if own.pwm > 0.0 else math.inf
