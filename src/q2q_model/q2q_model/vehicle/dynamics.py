"""Rigid-body accelerations of a quadcopter, equations (1)-(9) of the paper, for any batch of vehicles.

    phi''   = theta' psi' a1 + theta' a2 Omega_r + b1 U2                     (1)
    theta'' = phi' psi' a3 - phi' a4 Omega_r + b2 U3                         (2)
    psi''   = theta' phi' a5 + b3 U4                                         (3)
    x'' = U1/m u_x + eta_x,   y'' = U1/m u_y + eta_y                         (4), (5), (7), (8)
    z'' = -g + U1/m cos(phi) cos(theta) + eta_z                              (6), (9)

Interpretation. The angles are roll, pitch, yaw (the paper's text says pitch, yaw, roll). (1)-(3) are Euler's
equations of a rigid body if the primed angles are body rates; the Euler angle rates, which the paper uses,
differ by tilt times rate. b3 = 1/Izz, since U4 is a torque; the printed l/Izz would make it a force.

| symbol | name | meaning [unit] |
|---|---|---|
| phi theta psi | attitude | roll, pitch, yaw, Z-Y-X [rad], (..., 3) |
| phi' theta' psi' | rates | roll, pitch, yaw rate [rad/s], (..., 3) |
| U1 | thrust | collective thrust along body z [N], (...) |
| U2 U3 U4 | moments | force difference about roll and pitch [N], torque about yaw [N m], (..., 3) |
| Omega_r | rotor_speed_sum | signed sum of the rotor speeds [rad/s], (...) |
| eta | eta | acceleration due to neighbours' downwash, F / m [m/s^2], world, (..., 3) |
"""

import numpy as np

from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import GRAVITY, Vehicle

NO_DRAFT = np.zeros(3)
"""eta of an isolated vehicle [m/s^2]."""


def angular_acceleration(
    rates: Array, moments: Array, vehicle: Vehicle, rotor_speed_sum: Array | float = 0.0
) -> Array:
    """Return phi'', theta'', psi'' [rad/s^2], (..., 3), by (1)-(3)."""
    ixx, iyy, izz = vehicle.inertia
    p, q, r = rates[..., 0], rates[..., 1], rates[..., 2]
    gyroscopic = vehicle.rotor_inertia * np.asarray(rotor_speed_sum)  # J_r Omega_r [N m s]
    roll = q * r * (iyy - izz) / ixx + q * gyroscopic / ixx + vehicle.arm / ixx * moments[..., 0]
    pitch = p * r * (izz - ixx) / iyy - p * gyroscopic / iyy + vehicle.arm / iyy * moments[..., 1]
    yaw = q * p * (ixx - iyy) / izz + moments[..., 2] / izz
    return np.stack(np.broadcast_arrays(roll, pitch, yaw), axis=-1)


def thrust_direction(attitude: Array) -> Array:
    """Return body z in the world, (u_x, u_y, cos phi cos theta), unit length, (..., 3)."""
    cos, sin = np.cos(attitude), np.sin(attitude)
    along_x = cos[..., 0] * sin[..., 1] * cos[..., 2] + sin[..., 0] * sin[..., 2]
    along_y = cos[..., 0] * sin[..., 1] * sin[..., 2] - sin[..., 0] * cos[..., 2]
    return np.stack([along_x, along_y, cos[..., 0] * cos[..., 1]], axis=-1)


def linear_acceleration(attitude: Array, thrust: Array, mass: float, eta: Array = NO_DRAFT) -> Array:
    """Return x'', y'', z'' [m/s^2], world, (..., 3), by (4)-(9); without `eta` by (4)-(6)."""
    thrust_acc = np.asarray(thrust)[..., None] / mass * thrust_direction(attitude)
    return np.asarray(thrust_acc + eta - np.array([0.0, 0.0, GRAVITY]))
