"""Turn PWM into forces: what the motors and the inertia of an airframe make of the firmware's numbers.

The house's scale (q2q_control.legacy) is linear: 60000 PWM on every motor is the vehicle's largest thrust.

    f = pwm * thrust_max / (4 * 60000)                                   one motor [N]
    r' = share_tilt * r,  p' = share_tilt * p,  y' = share_yaw * y       in the mixer (motors)

The firmware's attitude gains are PWM per radian, made for the Crazyflie's inertia. Another airframe is flown
by a build whose mixer gives the same angular acceleration for the same PWM:

    share_tilt = (k lever / Ixx) of the Crazyflie 2.0 over that of the airframe, share_yaw alike with c / Izz

so that clients see the stock gains on any airframe; on the Crazyflie 2.0 both shares are 1. The position
gains of Mellinger are newtons per metre: they grow with the mass (parameters). Its derivative of the rates
makes up for the rotors' lag, and grows with that: without lag it would drive itself.

| symbol | name | meaning [unit] |
|---|---|---|
| k | newton_per_pwm | force of one motor per PWM [N] |
| c | drag_to_thrust | [m] |
| lever | | arm / sqrt 2 [m] |

Left out: the motors' thrust curve and its battery compensation (they undo each other in the firmware).
"""

import math
from dataclasses import dataclass

from q2q_control.legacy import PWM_MAX
from q2q_model.vehicle import CRAZYFLIE_2_0, Vehicle

MOTORS = 4


@dataclass(frozen=True, slots=True)
class Airframe:
    """Hold what the mixer needs."""

    newton_per_pwm: float
    """k [N]."""
    share_tilt: float
    share_yaw: float
    share_lag: float
    """The rotors' lag over that of the Crazyflie 2.0."""
    mass: float
    """[kg]"""

    @property
    def pwm_per_newton(self) -> float:
        """Return the PWM of every motor per newton of collective thrust: `ctrlMel.massThrust` [1/N]."""
        return 1.0 / (MOTORS * self.newton_per_pwm)

    @property
    def stiffness_share(self) -> float:
        """Return the mass over that of the Crazyflie 2.0: what scales gains in N/m."""
        return self.mass / CRAZYFLIE_2_0.mass


def airframe_of(vehicle: Vehicle) -> Airframe:
    """Return the airframe of a vehicle."""
    tilt, yaw = _agility(vehicle)
    stock_tilt, stock_yaw = _agility(CRAZYFLIE_2_0)
    lag = vehicle.thrust_lag / CRAZYFLIE_2_0.thrust_lag
    return Airframe(_newton_per_pwm(vehicle), stock_tilt / tilt, stock_yaw / yaw, lag, vehicle.mass)


def _newton_per_pwm(vehicle: Vehicle) -> float:
    return vehicle.thrust_max / (MOTORS * PWM_MAX)


def _agility(vehicle: Vehicle) -> tuple[float, float]:
    """Return angular acceleration per PWM of tilt and of yaw [rad/s^2]."""
    force = _newton_per_pwm(vehicle)
    lever = vehicle.arm / math.sqrt(2.0)
    return force * lever / vehicle.inertia[0], force * vehicle.drag_to_thrust / vehicle.inertia[2]
