"""Compare what would be sent at hover with what the vehicle itself takes for hover.

A stick of RPYT asks for PWM_c = 65535 m g / f_full by the table of vehicle and firmware. The vehicle's own
Mellinger controller, with the parameters that were read from it, starts from

    PWM_o = ctrlMel.massThrust * ctrlMel.mass * g

so PWM_c / PWM_o far from 1 tells of a wrong vehicle, a wrong firmware or a mass never set. massThrust is
132000 on every stock build, which on current firmware is 3 % below 65535 / f_full (mass_thrust_of), but 60 %
above it on a Brushless and 45 % with the upgrade kit: there it must be set.
"""

import math
from dataclasses import dataclass

from q2q_model.vehicle.constants import GRAVITY, Vehicle
from q2q_model.vehicle.thrust_map import PWM_FULL

OWN_PARAMETERS = ("ctrlMel.mass", "ctrlMel.massThrust")
"""What must be read from a vehicle."""


@dataclass(frozen=True, slots=True)
class OwnHover:
    """Parameters of a vehicle that say at which PWM it hovers."""

    mass: float
    """ctrlMel.mass [kg]."""
    mass_thrust: float
    """ctrlMel.massThrust [1/N]."""

    @property
    def pwm(self) -> float:
        """Return PWM_o."""
        return self.mass_thrust * self.mass * GRAVITY


def hover_pwm(vehicle: Vehicle) -> float:
    """Return PWM_c, what a stick would ask of each motor at hover."""
    return PWM_FULL * vehicle.hover_thrust / vehicle.full_pwm_thrust


def mass_thrust_of(vehicle: Vehicle) -> float:
    """Return the ctrlMel.massThrust [1/N] that gives a vehicle the thrust its controller asks for."""
    return PWM_FULL / vehicle.full_pwm_thrust


def hover_ratio(vehicle: Vehicle, own: OwnHover) -> float:
    """Return PWM_c / PWM_o; infinite where the vehicle's own parameters give no thrust."""
    return hover_pwm(vehicle) / own.pwm if own.pwm > 0.0 else math.inf
