"""Airframe parameters that map the firmware's PWM to forces and angular accelerations.

The scale is that of q2q_model.vehicle.thrust_map, linear:

    f = pwm * full_pwm_thrust / (4 * 65535)                              one motor [N]
    r' = share_tilt * r,  p' = share_tilt * p,  y' = share_yaw * y       in the mixer (motors)

The firmware's attitude gains are PWM per radian, tuned for the Crazyflie's inertia. A Crazyflie uses its
stock build. Any other airframe uses a build whose mixer gives the angular acceleration of the Crazyflie 2.0
for the same PWM:

    share_tilt = (k lever / Ixx) of the Crazyflie 2.0 over that of the airframe, share_yaw alike with c / Izz

so that clients see the stock gains on any airframe; on a Crazyflie both factors are 1. The position gains of
Mellinger, in newtons per metre, scale with the mass (stiffness_share, 1 on a Crazyflie). Its derivative of
the rates compensates the rotor lag and scales with it: without lag it would destabilise the loop.

| symbol | name | meaning [unit] |
|---|---|---|
| k | newton_per_pwm | force of one motor per PWM [N] |
| c | drag_to_thrust | [m] |
| lever | | arm / sqrt 2 [m] |

The scale holds from 7000 PWM, below which a compensated motor stops, to full duty (thrust_curve). A motor
gives at most a quarter of thrust_max: a real battery sags under such a load. In an air with its own vehicles,
each rotor's own largest thrust limits it, and nothing else does (q2q_sim.plant.room_vehicle.body_of_room).
"""

import math
from dataclasses import dataclass

from q2q_model.vehicle.constants import CRAZYFLIE_2_0, Vehicle
from q2q_model.vehicle.thrust_map import MASS_THRUST, MOTOR_THRUST, PWM_FULL

MOTORS = 4


@dataclass(frozen=True, slots=True)
class Airframe:
    """Parameters of the mixer."""

    newton_per_pwm: float
    """k [N]."""
    share_tilt: float
    share_yaw: float
    share_lag: float
    """Factor of the derivative gain of Mellinger's rates."""
    stiffness_share: float
    """Factor of gains in N/m."""
    mass: float
    """[kg]"""
    pwm_per_newton: float
    """PWM of every motor per newton of collective thrust: `ctrlMel.massThrust` [1/N]."""
    rotor_max: float
    """Largest force of one motor [N]."""


def airframe_of(vehicle: Vehicle) -> Airframe:
    """Return the airframe of a vehicle."""
    force, most = _newton_per_pwm(vehicle), vehicle.thrust_max / MOTORS
    if vehicle.name in MOTOR_THRUST:
        return Airframe(force, 1.0, 1.0, 1.0, 1.0, vehicle.mass, MASS_THRUST, most)
    tilt, yaw = _agility(vehicle)
    stock_tilt, stock_yaw = _agility(CRAZYFLIE_2_0)
    lag = vehicle.thrust_lag / CRAZYFLIE_2_0.thrust_lag
    stiffness = vehicle.mass / CRAZYFLIE_2_0.mass
    return Airframe(
        force, stock_tilt / tilt, stock_yaw / yaw, lag, stiffness, vehicle.mass, 1.0 / (MOTORS * force), most
    )


def _newton_per_pwm(vehicle: Vehicle) -> float:
    return vehicle.full_pwm_thrust / (MOTORS * PWM_FULL)


def _agility(vehicle: Vehicle) -> tuple[float, float]:
    """Return angular acceleration per PWM of tilt and of yaw [rad/s^2]."""
    force = _newton_per_pwm(vehicle)
    lever = vehicle.arm / math.sqrt(2.0)
    return force * lever / vehicle.inertia[0], force * vehicle.drag_to_thrust / vehicle.inertia[2]
