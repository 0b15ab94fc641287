"""Physics step of one quadcopter: rigid body, rotor lag, onboard attitude loop, ground.

The equations are (1)-(9) in quaternion form, without small angles:

    v'  = -g e_z + T / m R(q) e_z + eta + a_air        T = f1 + f2 + f3 + f4
    I w' = tau + tau_air - w x (I w)                   tau from the rotors (q2q_control.attitude.allocation)
    q'  = q (w, 0) / 2
    f'  = (min(k f_c, f_max) - f) / T_lag              f_c: attitude law, then allocation, every step

One step of h: the rotor lag is exact for a constant command; v uses T of the new rotors and R of the old
attitude; position advances by the mean of old and new velocity, which is exact for constant acceleration;
w is integrated first, then q by exp(w h) (semi-implicit). The ground is at z = 0: there the vehicle stops,
level, with its yaw kept. A commanded thrust of zero stops the motors, as in the firmware.

| symbol | name | meaning [unit] |
|---|---|---|
| f | rotors | thrust of each rotor [N] |
| f_max | ceiling | largest thrust of a rotor [N] |
| k | gain | thrust over commanded thrust of a rotor: battery, wear [-] |
| T_lag | thrust_lag | [s]; decay = exp(-h / T_lag) |
| eta + a_air | push | acceleration by the air (downwash, ground) and by moving air [m/s^2], world |
| tau_air | | torque of the air [N m], body |
| h | step | [s] |

The compiled loops hold one row of numbers for each vehicle, with the columns below.
"""

import math
from typing import NamedTuple

import numpy as np

from q2q_control.attitude.allocation import rotor_frame
from q2q_control.attitude.allocation_kernel import allocate
from q2q_control.attitude.attitude_law import AttitudeGains, AttitudeParams, attitude_gains, attitude_torque
from q2q_model.compiled import BORROWING, compiled
from q2q_model.geometry.rotations import quat_from_euler
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import GRAVITY, Vehicle

X, Y, Z = 0, 1, 2
"""Columns of a state row: position [m], world."""
VX, VY, VZ = 3, 4, 5
"""Velocity [m/s], world."""
QX, QY, QZ, QW = 6, 7, 8, 9
"""Attitude, body to world."""
P, Q, R = 10, 11, 12
"""Body rates [rad/s]."""
F1, F2, F3, F4 = 13, 14, 15, 16
"""Rotor thrusts [N]."""
AX, AY, AZ = 17, 18, 19
"""Acceleration during the last step [m/s^2], world."""
ETA = 20
"""Vertical push of the air [m/s^2]."""
ETA_X, ETA_Y = 21, 22
"""Its horizontal push [m/s^2], world."""
TX, TY, TZ = 23, 24, 25
"""Its torque [N m], body."""
CEILING = 26
"""Largest thrust of a rotor [N]."""
STATE_WIDTH = 27
POS, VEL, QUAT = slice(X, VX), slice(VX, QX), slice(QX, P)
RATE, ROTORS, ACC = slice(P, F1), slice(F1, AX), slice(AX, ETA)
TORQUE = slice(TX, CEILING)

GAIN1 = 3
"""Column of the first rotor's gain in a drive row, after the acceleration by moving air [m/s^2]."""

Three = tuple[float, float, float]
Four = tuple[float, float, float, float]


class Body(NamedTuple):
    """Constants of a vehicle for a physics step."""

    gains: AttitudeGains
    """Of the attitude law."""
    frame: Three
    """Lever [m], drag [m], rotor_max [N] of a RotorFrame."""
    mass: float
    """[kg]"""
    decay: float
    """exp(-step / T_lag)"""
    step: float
    """[s]"""


def body_of(vehicle: Vehicle, attitude: AttitudeParams, step: float) -> Body:
    """Return the constants of `vehicle` for steps of `step` [s]."""
    decay = math.exp(-step / vehicle.thrust_lag) if vehicle.thrust_lag > 0.0 else 0.0
    frame = rotor_frame(vehicle)
    lever, drag, rotor_max = float(frame.lever), float(frame.drag), float(frame.rotor_max)
    return Body(attitude_gains(attitude, vehicle), (lever, drag, rotor_max), vehicle.mass, decay, step)


def state_at_rest(start: Array, mass: float) -> Array:
    """Return states (n, STATE_WIDTH) at rest at `start` (n, 4): x, y, z [m], yaw [rad].

    Above the ground the vehicles hover, on it their motors are off.
    """
    level = np.zeros(len(start))
    state = np.zeros((len(start), STATE_WIDTH))
    state[:, POS] = start[:, :3]
    state[:, QUAT] = quat_from_euler(level, level, start[:, 3])
    state[start[:, 2] > 0.0, ROTORS] = 0.25 * mass * GRAVITY
    state[:, CEILING] = np.inf
    return state


@compiled(**BORROWING)
def _torque(rotors: Four, lever: float, drag: float) -> Three:
    f1, f2, f3, f4 = rotors
    return lever * (-f1 - f2 + f3 + f4), lever * (-f1 + f2 + f3 - f4), drag * (-f1 + f2 - f3 + f4)


@compiled(**BORROWING)
def _tilt(quat: Four) -> Three:
    """Return roll, pitch [rad], and 0 for the yaw, which the attitude law does not read."""
    x, y, z, w = quat
    roll = math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    return roll, math.asin(min(max(2.0 * (w * y - z * x), -1.0), 1.0)), 0.0


@compiled(**BORROWING)
def _write_rotors(row: Array, command: Four, body: Body, commanded: Array) -> None:
    """Write the rotor thrusts that the onboard loop commands [N], (4,)."""
    thrust, roll, pitch, yaw_rate = command
    if thrust <= 0.0:
        commanded[:] = 0.0
        return
    lever, drag, _ = body.frame
    torque_now = _torque((row[F1], row[F2], row[F3], row[F4]), lever, drag)
    attitude = _tilt((row[QX], row[QY], row[QZ], row[QW]))
    rate = (row[P], row[Q], row[R])
    tx, ty, tz = attitude_torque(attitude, rate, torque_now, (roll, pitch, yaw_rate), body.gains)
    allocate((thrust, tx, ty, tz), body.frame, True, commanded)  # noqa: FBT003  numba takes no keywords here


@compiled(**BORROWING)
def _push(row: Array, push: Three, body: Body) -> None:
    """Integrate velocity and position over one step."""
    x, y, z, w = row[QX], row[QY], row[QZ], row[QW]
    thrust_acc = (row[F1] + row[F2] + row[F3] + row[F4]) / body.mass
    h = body.step
    row[AX] = thrust_acc * 2.0 * (x * z + w * y) + push[0]
    row[AY] = thrust_acc * 2.0 * (y * z - w * x) + push[1]
    row[AZ] = thrust_acc * (1.0 - 2.0 * (x * x + y * y)) - GRAVITY + push[2]
    for k in range(3):
        before = row[VX + k]
        row[VX + k] = before + row[AX + k] * h
        row[X + k] += 0.5 * (before + row[VX + k]) * h


@compiled(**BORROWING)
def _half_turn(square: float) -> tuple[float, float]:
    """Return sin x / x and cos x for x^2 = square; below 1e-3 the series are exact to the last digit."""
    if square > 1e-3:
        x = math.sqrt(square)
        return math.sin(x) / x, math.cos(x)
    sine = 1.0 - square * (1.0 / 6.0 - square * (1.0 / 120.0 - square * (1.0 / 5040.0)))
    rest = 1.0 / 24.0 - square * (1.0 / 720.0 - square * (1.0 / 40320.0))
    return sine, 1.0 - square * (0.5 - square * rest)


@compiled(**BORROWING)
def _turn(row: Array, body: Body) -> None:
    """Integrate angular velocity and attitude over one step."""
    lever, drag, _ = body.frame
    tx, ty, tz = _torque((row[F1], row[F2], row[F3], row[F4]), lever, drag)
    ix, iy, iz = body.gains.inertia[0], body.gains.inertia[1], body.gains.inertia[2]
    h = body.step
    p, q, r = row[P], row[Q], row[R]
    tx, ty, tz = tx + row[TX], ty + row[TY], tz + row[TZ]
    wx = p + h * (tx + (iy - iz) * q * r) / ix
    wy = q + h * (ty + (iz - ix) * p * r) / iy
    wz = r + h * (tz + (ix - iy) * p * q) / iz
    row[P], row[Q], row[R] = wx, wy, wz
    s, c = _half_turn(0.25 * h * h * (wx * wx + wy * wy + wz * wz))
    s *= 0.5 * h
    ex, ey, ez = s * wx, s * wy, s * wz
    x, y, z, w = row[QX], row[QY], row[QZ], row[QW]
    nx = w * ex + x * c + y * ez - z * ey
    ny = w * ey - x * ez + y * c + z * ex
    nz = w * ez + x * ey - y * ex + z * c
    nw = w * c - x * ex - y * ey - z * ez
    scale = 1.5 - 0.5 * (nx * nx + ny * ny + nz * nz + nw * nw)  # 1 / sqrt near 1, by Newton
    row[QX], row[QY], row[QZ], row[QW] = nx * scale, ny * scale, nz * scale, nw * scale


@compiled(**BORROWING)
def _stand(row: Array, body: Body) -> None:
    """Stop a vehicle below the ground, level, with its yaw kept; acc includes the ground's reaction."""
    for k in range(3):
        after = max(row[VZ], 0.0) if k == Z else 0.0
        row[AX + k] += (after - row[VX + k]) / body.step
        row[VX + k] = after
        row[P + k] = 0.0
    row[Z] = 0.0
    x, y, z, w = row[QX], row[QY], row[QZ], row[QW]
    half_yaw = 0.5 * math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    row[QX], row[QY], row[QZ], row[QW] = 0.0, 0.0, math.sin(half_yaw), math.cos(half_yaw)


@compiled(**BORROWING)
def move(row: Array, commanded: Array, drive: Array, body: Body) -> None:
    """Advance rotors and rigid body by one step under commanded rotor thrusts [N], (4,)."""
    for k in range(4):
        target = min(drive[GAIN1 + k] * commanded[k], row[CEILING])
        row[F1 + k] = target + (row[F1 + k] - target) * body.decay
    _push(row, (drive[X] + row[ETA_X], drive[Y] + row[ETA_Y], drive[Z] + row[ETA]), body)
    _turn(row, body)
    if row[Z] < 0.0:
        _stand(row, body)


@compiled(**BORROWING)
def advance(row: Array, command: Four, drive: Array, body: Body, commanded: Array) -> None:
    """Advance one vehicle by a step.

    Args:
        row: state, (STATE_WIDTH,), changed in place.
        command: thrust [N], roll, pitch [rad], yaw rate [rad/s].
        drive: acceleration by moving air [m/s^2], world, then the gain of each rotor, (7,).
        body: constants of the vehicle.
        commanded: workspace for rotor thrusts, (4,).
    """
    _write_rotors(row, command, body, commanded)
    move(row, commanded, drive, body)
