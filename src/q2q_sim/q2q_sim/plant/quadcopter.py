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
| eta + a_air | push | acceleration by the air (downwash, ground) and by wind [m/s^2], world |
| tau_air | | torque of the air [N m], body |
| h | step | [s] |

The compiled loops hold one row of numbers for each vehicle, with the columns below.
"""

import math
from typing import NamedTuple

import numpy as np

from q2q_control.attitude.allocation import rotor_frame
from q2q_control.attitude.allocation_kernel import allocate
from q2q_control.attitude.attitude_law import (
    AttitudeGains,
    AttitudeParams,
    Axes,
    attitude_gains,
    attitude_torque,
)
from q2q_model.compiled import BORROWING, compiled
from q2q_model.geometry.rotations import quat_from_euler
from q2q_model.geometry.yaw import yaw_of
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
CEILING1, CEILING2, CEILING3, CEILING4 = 26, 27, 28, 29
"""Largest thrust of each rotor [N], less its load (room_air.RateLoadTerm)."""
STATE_WIDTH = 30
POS, VEL, QUAT = slice(X, VX), slice(VX, QX), slice(QX, P)
RATE, ROTORS, ACC = slice(P, F1), slice(F1, AX), slice(AX, ETA)
TORQUE = slice(TX, CEILING1)

GAIN1 = 3
"""Column of the first rotor's gain in a drive row, after the acceleration by wind [m/s^2]."""

Two = tuple[float, float]
Three = tuple[float, float, float]
Four = tuple[float, float, float, float]


SMALL_SQUARE = 1e-3
"""Square of an angle up to which the series of its sine and cosine are exact [rad^2]."""


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
    state[:, CEILING1:] = np.inf
    return state


@compiled(**BORROWING)
def rotor_torque(rotors: Four, lever: float, drag: float) -> Three:
    """Return the torque of the rotors [N m], body."""
    f1, f2, f3, f4 = rotors
    return lever * (-f1 - f2 + f3 + f4), lever * (-f1 + f2 + f3 - f4), drag * (-f1 + f2 - f3 + f4)


@compiled(**BORROWING)
def tilt(quat: Four) -> Three:
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
    torque_now = rotor_torque((row[F1], row[F2], row[F3], row[F4]), lever, drag)
    attitude = tilt((row[QX], row[QY], row[QZ], row[QW]))
    rate = (row[P], row[Q], row[R])
    tx, ty, tz = attitude_torque(attitude, rate, torque_now, (roll, pitch, yaw_rate), body.gains)
    allocate((thrust, tx, ty, tz), body.frame, True, commanded)  # noqa: FBT003  numba takes no keywords here


@compiled(**BORROWING)
def acceleration(quat: Four, rotors: Four, push: Three, body: Body) -> Three:
    """Return the acceleration [m/s^2], world."""
    x, y, z, w = quat
    thrust_acc = (rotors[0] + rotors[1] + rotors[2] + rotors[3]) / body.mass
    return (
        thrust_acc * 2.0 * (x * z + w * y) + push[0],
        thrust_acc * 2.0 * (y * z - w * x) + push[1],
        thrust_acc * (1.0 - 2.0 * (x * x + y * y)) - GRAVITY + push[2],
    )


@compiled(**BORROWING)
def rate_after(rate: Three, torque: Three, inertia: Axes, step: float) -> Three:
    """Return the body rates after one step under the torque [N m] of rotors and air."""
    p, q, r = rate
    ix, iy, iz = inertia[0], inertia[1], inertia[2]
    return (
        p + step * (torque[0] + (iy - iz) * q * r) / ix,
        q + step * (torque[1] + (iz - ix) * p * r) / iy,
        r + step * (torque[2] + (ix - iy) * p * q) / iz,
    )


@compiled(**BORROWING)
def small_half_turn(square: float) -> Two:
    """Return sin x / x and cos x for x^2 = square up to SMALL_SQUARE; exact to the last digit."""
    sine = 1.0 - square * (1.0 / 6.0 - square * (1.0 / 120.0 - square * (1.0 / 5040.0)))
    rest = 1.0 / 24.0 - square * (1.0 / 720.0 - square * (1.0 / 40320.0))
    return sine, 1.0 - square * (0.5 - square * rest)


@compiled(**BORROWING)
def _half_turn(square: float) -> Two:
    """Return sin x / x and cos x for x^2 = square."""
    if square > SMALL_SQUARE:
        x = math.sqrt(square)
        return math.sin(x) / x, math.cos(x)
    return small_half_turn(square)


@compiled(**BORROWING)
def half_turn_squared(rate: Three, step: float) -> float:
    """Return the square of half the angle of a step's turn [rad^2]."""
    p, q, r = rate
    return 0.25 * step * step * (p * p + q * q + r * r)


@compiled(**BORROWING)
def quat_after(quat: Four, rate: Three, half_turn: Two, step: float) -> Four:
    """Return the attitude after one step at `rate`; `half_turn` is sin x / x, cos x of half the angle."""
    s, c = half_turn
    s *= 0.5 * step
    ex, ey, ez = s * rate[0], s * rate[1], s * rate[2]
    x, y, z, w = quat
    nx = w * ex + x * c + y * ez - z * ey
    ny = w * ey - x * ez + y * c + z * ex
    nz = w * ez + x * ey - y * ex + z * c
    nw = w * c - x * ex - y * ey - z * ez
    scale = 1.5 - 0.5 * (nx * nx + ny * ny + nz * nz + nw * nw)  # 1 / sqrt near 1, by Newton
    return nx * scale, ny * scale, nz * scale, nw * scale


@compiled(**BORROWING)
def _push(row: Array, push: Three, body: Body) -> None:
    """Integrate velocity and position over one step."""
    quat, rotors = (row[QX], row[QY], row[QZ], row[QW]), (row[F1], row[F2], row[F3], row[F4])
    row[AX], row[AY], row[AZ] = acceleration(quat, rotors, push, body)
    for k in range(3):
        before = row[VX + k]
        row[VX + k] = before + row[AX + k] * body.step
        row[X + k] += 0.5 * (before + row[VX + k]) * body.step


@compiled(**BORROWING)
def _turn(row: Array, body: Body) -> None:
    """Integrate angular velocity and attitude over one step."""
    lever, drag, _ = body.frame
    tx, ty, tz = rotor_torque((row[F1], row[F2], row[F3], row[F4]), lever, drag)
    torque = (tx + row[TX], ty + row[TY], tz + row[TZ])
    rate = rate_after((row[P], row[Q], row[R]), torque, body.gains.inertia, body.step)
    half_turn = _half_turn(half_turn_squared(rate, body.step))
    row[P], row[Q], row[R] = rate
    row[QX], row[QY], row[QZ], row[QW] = quat_after(
        (row[QX], row[QY], row[QZ], row[QW]), rate, half_turn, body.step
    )


@compiled(**BORROWING)
def _stand(row: Array, body: Body) -> None:
    """Stop a vehicle below the ground, level, with its yaw kept; acc includes the ground's reaction."""
    for k in range(3):
        after = max(row[VZ], 0.0) if k == Z else 0.0
        row[AX + k] += (after - row[VX + k]) / body.step
        row[VX + k] = after
        row[P + k] = 0.0
    row[Z] = 0.0
    half_yaw = 0.5 * yaw_of(row[QX], row[QY], row[QZ], row[QW])
    row[QX], row[QY], row[QZ], row[QW] = 0.0, 0.0, math.sin(half_yaw), math.cos(half_yaw)


@compiled(**BORROWING)
def excess_share(commanded: Four, ceilings: Four) -> float:
    """Return a quarter of what the rotors are asked for beyond their ceilings [N].

    Every rotor that gives as much loses it: rotors at their limit cost the vehicle thrust, not attitude.
    """
    one, two = max(commanded[0] - ceilings[0], 0.0), max(commanded[1] - ceilings[1], 0.0)
    three, four = max(commanded[2] - ceilings[2], 0.0), max(commanded[3] - ceilings[3], 0.0)
    return 0.25 * (one + two + three + four)


@compiled(**BORROWING)
def share_given(commanded: Four, ceilings: Four, lost: float) -> float:
    """Return the share of its thrust, less what is `lost` [N], that every rotor gives.

    It is 1 unless a rotor is asked for less than is lost: then together they give what each could by itself.
    """
    one, two, three, four = commanded
    if min(one, two, three, four) >= lost:
        return 1.0
    able = max(min(one, ceilings[0]), 0.0) + max(min(two, ceilings[1]), 0.0)
    able += max(min(three, ceilings[2]), 0.0) + max(min(four, ceilings[3]), 0.0)
    asked = max(one - lost, 0.0) + max(two - lost, 0.0) + max(three - lost, 0.0) + max(four - lost, 0.0)
    return able / asked if able < asked else 1.0


@compiled(**BORROWING)
def move(row: Array, commanded: Array, drive: Array, body: Body) -> None:
    """Advance rotors and rigid body by one step under commanded rotor thrusts [N], (4,)."""
    ceilings = (row[CEILING1], row[CEILING2], row[CEILING3], row[CEILING4])
    asked = (commanded[0], commanded[1], commanded[2], commanded[3])
    lost = excess_share(asked, ceilings)
    share = share_given(asked, ceilings, lost)
    for k in range(4):
        target = drive[GAIN1 + k] * share * max(commanded[k] - lost, 0.0)
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
        drive: acceleration by wind [m/s^2], world, then the gain of each rotor, (7,).
        body: constants of the vehicle.
        commanded: workspace for rotor thrusts, (4,).
    """
    _write_rotors(row, command, body, commanded)
    move(row, commanded, drive, body)
