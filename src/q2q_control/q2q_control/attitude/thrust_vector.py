"""Collective thrust, roll, pitch and yaw rate that give a desired acceleration: (22)-(25) with their limits.

With a the desired acceleration (the reference's, plus feedback, minus the downwash eta):

    U1      = m (g + a_z) / (cos phi cos theta)            before (22), and 5.1 with v - eta^z for a_z
    u_x, u_y = m / U1 [a_x, a_y]                           (24), (25)
    theta_d = u_x cos psi + u_y sin psi                    small angles, as printed
    phi_d   = u_x sin psi - u_y cos psi
    r_d     = psi'_ref + k_psi (psi_ref - psi)             yaw rate

cos phi cos theta is that of the present attitude, so that the vertical force is right at any tilt. Exact
instead of small angles: the body's z axis along (a_x, a_y, g + a_z), in the frame turned by the yaw psi,

    theta_d = atan2(a_1, g + a_z),  phi_d = atan2(-a_2, hypot(a_1, g + a_z))
    a_1 = a_x cos psi + a_y sin psi,  a_2 = a_y cos psi - a_x sin psi

Limits: f m g <= U1 <= thrust_max (rotors do not pull down, and motors that stop hold no attitude); f m g
where body z does not point up, since more would push down; the angle between thrust and vertical at most
tilt_max, the direction of the tilt kept.

| symbol | name | meaning [unit] |
|---|---|---|
| a | acc | desired acceleration [m/s^2], world, (n, 3) |
| psi | yaw | present yaw [rad] |
| U1 | thrust | collective thrust [N] |
| phi_d theta_d | roll pitch | [rad] |
| r_d | yaw_rate | [rad/s] |
| k_psi | k_yaw | [1/s] |
| f | LEAST_THRUST | least thrust over weight [-] (q2q_model.vehicle.attitude_limits) |
"""

import math
from typing import NamedTuple

import numpy as np

from q2q_control.inputs.alignment import QUAT_AT, YAW, YAW_RATE
from q2q_model.compiled import compiled
from q2q_model.geometry.yaw import yaw_of
from q2q_model.signals.values import Array, Mask
from q2q_model.vehicle.attitude_limits import LEAST_THRUST
from q2q_model.vehicle.constants import GRAVITY, Vehicle

UPRIGHT_MIN = 0.3
"""Least cos phi cos theta that thrust is raised for: beyond a tilt of 72.5 deg it is raised as at that."""
WEIGHT_MIN = 0.3
"""Least vertical thrust over weight that tilt is computed for: a falling vehicle is not tilted further."""


class ThrustLimits(NamedTuple):
    """Mass, limits and yaw law of one vehicle."""

    mass: float
    """[kg]"""
    thrust_max: float
    """[N]"""
    tilt_max: float
    """[rad]"""
    exact: bool
    """Exact attitude instead of small angles."""
    k_yaw: float
    """[1/s]"""
    yaw_rate_max: float
    """[rad/s]"""


PlainLimits = tuple[float, float, float, bool, float, float]
"""Fields of ThrustLimits, which numba takes from Python in less than half the time."""


def largest_thrust(vehicle: Vehicle, bound: float | None) -> float:
    """Return the largest collective thrust that a controller may command [N].

    Args:
        vehicle: whose own limit holds as well.
        bound: thrust_max of a controller with thrust_limited [N]; None without.

    Raises:
        ValueError: the bound does not carry the vehicle.
    """
    if bound is None:
        return vehicle.rpyt_thrust_max
    if bound <= vehicle.hover_thrust:
        least = f"must be above the weight of {vehicle.name}, {vehicle.hover_thrust:.6g} N"
        raise ValueError(f"thrust_max = {bound:g} N with thrust_limited; {least}")
    return min(bound, vehicle.rpyt_thrust_max)


class Excess(NamedTuple):
    """Desired command beyond its limits."""

    thrust: float
    """Signed [N]; 0 within the limits."""
    tilt: bool


class _Tilt(NamedTuple):
    roll: float
    pitch: float
    cut: bool


@compiled
def command_rows(acc: Array, table: Array, limits: ThrustLimits) -> tuple[Array, Mask]:
    """Return thrust, roll, pitch, yaw rate (n, 4) and saturation (n,) of desired accelerations (n, 3).

    `table` is that of q2q_control.inputs.alignment.
    """
    n = table.shape[0]
    values, saturated = np.empty((n, 4)), np.empty(n, np.bool_)
    for i in range(n):
        excess = write_command(acc[i], table[i], limits, values[i])
        saturated[i] = excess.tilt or excess.thrust != 0.0
    return values, saturated


@compiled
def write_command(acc: Array, row: Array, limits: ThrustLimits, values: Array) -> Excess:
    """Write the command of `acc` (3,) to `values` (4,): thrust, roll, pitch, yaw rate; return its excess.

    `row` is one of the table of q2q_control.inputs.alignment.
    """
    upright = 1.0 - 2.0 * (row[QUAT_AT] * row[QUAT_AT] + row[QUAT_AT + 1] * row[QUAT_AT + 1])
    desired = limits.mass * (GRAVITY + acc[2]) / max(upright, UPRIGHT_MIN)
    least = LEAST_THRUST * limits.mass * GRAVITY
    thrust = min(max(desired, least), limits.thrust_max if upright > 0.0 else least)
    yaw = yaw_of(row[QUAT_AT], row[QUAT_AT + 1], row[QUAT_AT + 2], row[QUAT_AT + 3])
    tilt = _tilt(acc, yaw, thrust, limits)
    wrapped = (row[YAW] - yaw + math.pi) % (2.0 * math.pi) - math.pi
    yaw_rate = row[YAW_RATE] + limits.k_yaw * wrapped
    values[0], values[1], values[2] = thrust, tilt.roll, tilt.pitch
    values[3] = min(max(yaw_rate, -limits.yaw_rate_max), limits.yaw_rate_max)
    return Excess(desired - thrust, tilt.cut)


@compiled
def _tilt(acc: Array, yaw: float, thrust: float, limits: ThrustLimits) -> _Tilt:
    """Return roll, pitch [rad], and whether tilt_max cuts them."""
    forward = acc[0] * math.cos(yaw) + acc[1] * math.sin(yaw)
    left = acc[1] * math.cos(yaw) - acc[0] * math.sin(yaw)
    if limits.exact:
        vertical = max(GRAVITY + acc[2], WEIGHT_MIN * GRAVITY)
        forward, left, most = forward / vertical, left / vertical, math.tan(limits.tilt_max)
    else:
        vertical = max(thrust / limits.mass, WEIGHT_MIN * GRAVITY)
        forward, left, most = forward / vertical, left / vertical, limits.tilt_max
    side = math.sqrt(forward * forward + left * left)
    cut = side > most
    if cut:
        forward, left = forward * most / side, left * most / side
    if limits.exact:
        return _Tilt(-math.atan2(left, math.sqrt(forward * forward + 1.0)), math.atan(forward), cut)
    return _Tilt(-left, forward, cut)
