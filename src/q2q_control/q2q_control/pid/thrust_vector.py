"""Turn a wanted acceleration into collective thrust, roll and pitch: (22)-(25) with their limits.

With a the wanted acceleration (the reference's, plus feedback, minus the downwash eta):

    U1      = m (g + a_z) / (cos phi cos theta)            before (22), and 5.1 with v - eta^z for a_z
    u_x, u_y = m / U1 [a_x, a_y]                           (24), (25)
    theta_d = u_x cos psi + u_y sin psi                    small angles, as printed
    phi_d   = u_x sin psi - u_y cos psi

cos phi cos theta is that of the attitude now, so that the vertical force is right whatever the tilt. Exact
instead of small angles: the body's z axis along (a_x, a_y, g + a_z), in the frame turned by the yaw psi,

    theta_d = atan2(a_1, g + a_z),  phi_d = atan2(-a_2, hypot(a_1, g + a_z))
    a_1 = a_x cos psi + a_y sin psi,  a_2 = a_y cos psi - a_x sin psi

Limits: 0 <= U1 <= thrust_max (rotors do not pull down); the angle between thrust and vertical at most
tilt_max, the direction of the tilt kept.

| symbol | name | meaning [unit] |
|---|---|---|
| a | acc | wanted acceleration [m/s^2], world, (n, 3) |
| psi | yaw | yaw now [rad], (n,) |
| U1 | thrust | collective thrust [N], (n,) |
| phi_d theta_d | roll pitch | [rad], (n,) |
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from q2q_model.geometry.rotations import yaw_from_quat
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import GRAVITY

UPRIGHT_MIN = 0.3
"""cos phi cos theta below which (tilted by 70 deg) thrust is no longer raised for it."""
WEIGHT_MIN = 0.3
"""Vertical thrust over weight below which tilt is no longer raised for it: none tilts a falling vehicle."""


@dataclass(frozen=True, slots=True)
class ThrustLimits:
    """Mass and thrust limits of one vehicle."""

    mass: float
    """[kg]"""
    thrust_max: float
    """[N]"""
    tilt_max: float
    """[rad]"""
    exact: bool
    """Exact inverse instead of small angles."""


@dataclass(frozen=True, slots=True)
class ThrustVector:
    """Thrust and attitude of each vehicle, and the limits that cut them."""

    thrust: Array
    """U1 [N], (n,)."""
    roll: Array
    """phi [rad], (n,)."""
    pitch: Array
    """theta [rad], (n,)."""
    cut_thrust: Array
    """+1 where thrust_max cut, -1 where 0 did, else 0, (n,)."""
    cut_tilt: NDArray[np.bool_]
    """Where tilt_max cut, (n,)."""


def thrust_vector(acc: Array, quat: Array, limits: ThrustLimits) -> ThrustVector:
    """Return what accelerates vehicles of attitude `quat` (n, 4) by `acc` [m/s^2], world, (n, 3)."""
    upright = 1.0 - 2.0 * (quat[:, 0] ** 2 + quat[:, 1] ** 2)  # cos phi cos theta
    lift = GRAVITY + acc[:, 2]
    wanted = limits.mass * lift / np.maximum(upright, UPRIGHT_MIN)
    thrust = np.minimum(np.maximum(wanted, 0.0), limits.thrust_max)
    yaw = yaw_from_quat(quat)
    cos_yaw, sin_yaw = np.cos(yaw), np.sin(yaw)
    forward = acc[:, 0] * cos_yaw + acc[:, 1] * sin_yaw
    left = acc[:, 1] * cos_yaw - acc[:, 0] * sin_yaw
    if limits.exact:
        roll, pitch, cut = _exact(forward, left, np.maximum(lift, WEIGHT_MIN * GRAVITY), limits.tilt_max)
    else:
        specific = np.maximum(thrust / limits.mass, WEIGHT_MIN * GRAVITY)
        roll, pitch, cut = _small(forward / specific, left / specific, limits.tilt_max)
    return ThrustVector(thrust, roll, pitch, np.sign(wanted - thrust), cut)


def _small(forward: Array, left: Array, tilt_max: float) -> tuple[Array, Array, NDArray[np.bool_]]:
    tilt = np.sqrt(forward * forward + left * left)
    cut = tilt > tilt_max
    share = tilt_max / np.maximum(tilt, tilt_max)
    return -left * share, forward * share, cut


def _exact(
    forward: Array, left: Array, lift: Array, tilt_max: float
) -> tuple[Array, Array, NDArray[np.bool_]]:
    side_max = lift * np.tan(tilt_max)
    side = np.sqrt(forward * forward + left * left)
    share = side_max / np.maximum(side, side_max)
    forward, left = forward * share, left * share
    pitch = np.arctan2(forward, lift)
    roll = np.arctan2(-left, np.sqrt(forward * forward + lift * lift))
    return roll, pitch, side > side_max
