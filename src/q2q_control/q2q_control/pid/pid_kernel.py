"""Run the law of `q2q_control.pid.pid` over the rows of a tick in a compiled loop.

The equations are those of `q2q_control.pid.pid` and `q2q_control.pid.thrust_vector`, whose numpy form a test
compares: on two vehicles numpy's calls cost ten times the arithmetic. Columns of `table` are those of
q2q_control.inputs.alignment, entries of `numbers` those of `packed_numbers`.
"""

import math

import numpy as np
from numpy.typing import NDArray

from q2q_control.pid.thrust_vector import UPRIGHT_MIN, WEIGHT_MIN, ThrustLimits
from q2q_model.compiled import compiled
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import GRAVITY

_K_P, _K_D, _K_I, _INTEGRAL_MAX = 0, 3, 6, 9
_MASS, _THRUST_MAX, _TILT_MAX, _EXACT, _K_YAW, _YAW_RATE_MAX = 12, 13, 14, 15, 16, 17
_POS, _VEL, _QUAT, _REF_POS, _REF_VEL, _REF_ACC, _YAW, _YAW_RATE, _ETA = 0, 3, 6, 10, 13, 16, 19, 20, 21


def packed_numbers(gains: Array, limits: ThrustLimits, yaw: tuple[float, float]) -> Array:
    """Return what the loop reads, (18,): `gains` of pid_gains (4, 3); `yaw` k_yaw, yaw_rate_max."""
    scalars = [limits.mass, limits.thrust_max, limits.tilt_max, float(limits.exact), *yaw]
    return np.concatenate([gains.ravel(), scalars])


@compiled
def pid_rows(table: Array, integral: Array, numbers: Array, dt: float) -> tuple[Array, NDArray[np.bool_]]:
    """Return thrust, roll, pitch, yaw rate (n, 4) and saturation (n,); advance `integral` (n, 3) in place."""
    n = table.shape[0]
    values, saturated = np.empty((n, 4)), np.empty(n, np.bool_)
    acc = np.empty(3)
    for i in range(n):
        row = table[i]
        for k in range(3):
            acc[k] = row[_REF_ACC + k] + numbers[_K_P + k] * (row[_REF_POS + k] - row[_POS + k])
            acc[k] += numbers[_K_D + k] * (row[_REF_VEL + k] - row[_VEL + k])
            acc[k] += integral[i, k] - row[_ETA + k]
        beyond, cut = _command(acc, row, numbers, values[i])
        saturated[i] = cut or beyond != 0.0
        _integrate(integral[i], row, acc, numbers, (dt, beyond, cut))
    return values, saturated


@compiled
def command_rows(acc: Array, table: Array, numbers: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Return thrust, roll, pitch, yaw rate (n, 4) and saturation (n,) of wanted accelerations (n, 3)."""
    n = table.shape[0]
    values, saturated = np.empty((n, 4)), np.empty(n, np.bool_)
    for i in range(n):
        beyond, cut = _command(acc[i], table[i], numbers, values[i])
        saturated[i] = cut or beyond != 0.0
    return values, saturated


@compiled
def _command(acc: Array, row: Array, numbers: Array, values: Array) -> tuple[float, bool]:
    """Write thrust, roll, pitch, yaw rate; return how far thrust is beyond its limit, and whether tilt is."""
    thrust, beyond = _thrust(acc[2], row, numbers)
    yaw = _yaw_of(row)
    roll, pitch, cut = _tilt(acc, yaw, thrust, numbers)
    wrapped = (row[_YAW] - yaw + math.pi) % (2.0 * math.pi) - math.pi
    yaw_rate = row[_YAW_RATE] + numbers[_K_YAW] * wrapped
    values[0], values[1], values[2] = thrust, roll, pitch
    values[3] = min(max(yaw_rate, -numbers[_YAW_RATE_MAX]), numbers[_YAW_RATE_MAX])
    return beyond, cut


@compiled
def _thrust(acc_z: float, row: Array, numbers: Array) -> tuple[float, float]:
    upright = 1.0 - 2.0 * (row[_QUAT] * row[_QUAT] + row[_QUAT + 1] * row[_QUAT + 1])
    wanted = numbers[_MASS] * (GRAVITY + acc_z) / max(upright, UPRIGHT_MIN)
    thrust = min(max(wanted, 0.0), numbers[_THRUST_MAX])
    return thrust, wanted - thrust


@compiled
def _yaw_of(row: Array) -> float:
    x, y, z, w = row[_QUAT], row[_QUAT + 1], row[_QUAT + 2], row[_QUAT + 3]
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


@compiled
def _tilt(acc: Array, yaw: float, thrust: float, numbers: Array) -> tuple[float, float, bool]:
    forward = acc[0] * math.cos(yaw) + acc[1] * math.sin(yaw)
    left = acc[1] * math.cos(yaw) - acc[0] * math.sin(yaw)
    exact = numbers[_EXACT] > 0.0
    if exact:
        lift = max(GRAVITY + acc[2], WEIGHT_MIN * GRAVITY)
        forward, left, limit = forward / lift, left / lift, math.tan(numbers[_TILT_MAX])
    else:
        specific = max(thrust / numbers[_MASS], WEIGHT_MIN * GRAVITY)
        forward, left, limit = forward / specific, left / specific, numbers[_TILT_MAX]
    side = math.sqrt(forward * forward + left * left)
    cut = side > limit
    if cut:
        forward, left = forward * limit / side, left * limit / side
    if exact:
        return -math.atan2(left, math.sqrt(forward * forward + 1.0)), math.atan(forward), cut
    return -left, forward, cut


@compiled
def _integrate(
    integral: Array, row: Array, acc: Array, numbers: Array, limits: tuple[float, float, bool]
) -> None:
    dt, beyond, cut = limits
    outward = 0.0
    for k in range(2):
        outward += acc[k] * numbers[_K_I + k] * (row[_REF_POS + k] - row[_POS + k])
    for k in range(3):
        step = numbers[_K_I + k] * (row[_REF_POS + k] - row[_POS + k]) * dt
        if (k < 2 and cut and outward > 0.0) or (k == 2 and step * beyond > 0.0):
            continue
        integral[k] = min(max(integral[k] + step, -numbers[_INTEGRAL_MAX]), numbers[_INTEGRAL_MAX])
