"""Physics step of one quadcopter: rigid body, rotor lag, onboard attitude loop, ground.

The equations are (1)-(9) in quaternion form, without small angles:

    v'  = -g e_z + T / m R(q) e_z + eta + a_air        T = f1 + f2 + f3 + f4
    I w' = tau - w x (I w)                             tau from the rotors (q2q_control.attitude.allocation)
    q'  = q (w, 0) / 2
    f'  = (k f_c - f) / T_lag                          f_c: attitude law, then allocation, every step

One step of h: the rotor lag is exact for a constant command; v uses T of the new rotors and R of the old
attitude; position advances by the mean of old and new velocity, which is exact for constant acceleration;
w is integrated first, then q by exp(w h) (semi-implicit). The ground is at z = 0: there the vehicle stops,
level, with its yaw kept. A commanded thrust of zero stops the motors, as in the firmware.

| symbol | name | meaning [unit] |
|---|---|---|
| f | rotors | thrust of each rotor [N] |
| k | gain | thrust over commanded thrust of a rotor: battery, wear [-] |
| T_lag | thrust_lag | [s]; decay = exp(-h / T_lag) |
| eta + a_air | push | acceleration by downwash and by moving air [m/s^2], world |
| h | step | [s] |

For speed the compiled loops read one row of numbers a vehicle, laid out by the slices below, and one small
table of constants; small values pass between functions as tuples.
"""

import math
from functools import partial

import numpy as np

from q2q_control.attitude.allocation import rotor_frame
from q2q_control.attitude.allocation_kernel import allocate, packed_frame
from q2q_control.attitude.attitude_law import AttitudeParams, attitude_torque, packed_gains
from q2q_model.compiled import compiled
from q2q_model.geometry.rotations import quat_from_euler
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import GRAVITY, Vehicle

POS, VEL, QUAT, RATE, ROTORS, ACC = (
    slice(0, 3),
    slice(3, 6),
    slice(6, 10),
    slice(10, 13),
    slice(13, 17),
    slice(17, 20),
)
"""Columns of a state row: position, velocity [m, m/s, world], x y z w, body rates [rad/s], rotor thrusts [N],
acceleration during the last step [m/s^2, world]."""
ETA = 20
"""Column of the vertical downwash [m/s^2]."""
STATE_WIDTH = 21

FRAME_ROW, MASS_ROW = 4, 5
"""Rows of the constants: 0-3 packed_gains, 4 packed_frame, 5 mass [kg], decay, step [s]."""

Three = tuple[float, float, float]
Four = tuple[float, float, float, float]


def body_of(vehicle: Vehicle, attitude: AttitudeParams, step: float) -> Array:
    """Return the constants of `vehicle` for steps of `step` [s], (6, 3)."""
    decay = math.exp(-step / vehicle.thrust_lag) if vehicle.thrust_lag > 0.0 else 0.0
    gains, frame = packed_gains(attitude, vehicle), packed_frame(rotor_frame(vehicle))
    return np.vstack([gains, frame, [vehicle.mass, decay, step]])


def state_at_rest(start: Array, mass: float) -> Array:
    """Return states (n, 21) at rest at `start` (n, 4): x, y, z [m], yaw [rad].

    Above the ground the vehicles hover, on it their motors are off.
    """
    level = np.zeros(len(start))
    state = np.zeros((len(start), STATE_WIDTH))
    state[:, POS] = start[:, :3]
    state[:, QUAT] = quat_from_euler(level, level, start[:, 3])
    state[start[:, 2] > 0.0, ROTORS] = 0.25 * mass * GRAVITY
    return state


def _torque(rotors: Four, lever: float, drag: float) -> Three:
    f1, f2, f3, f4 = rotors
    return lever * (-f1 - f2 + f3 + f4), lever * (-f1 + f2 + f3 - f4), drag * (-f1 + f2 - f3 + f4)


def _tilt(quat: Four) -> Three:
    """Return roll, pitch [rad], and 0 for the yaw, which the attitude law does not read."""
    x, y, z, w = quat
    roll = math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    return roll, math.asin(min(max(2.0 * (w * y - z * x), -1.0), 1.0)), 0.0


def _wanted(row: Array, command: Four, body: Array, wanted: Array) -> None:
    """Write the rotor thrusts [N] that the onboard loop commands."""
    thrust, roll, pitch, yaw_rate = command
    if thrust <= 0.0:
        wanted[:] = 0.0
        return
    torque_now = torque((row[13], row[14], row[15], row[16]), body[4, 0], body[4, 1])
    attitude = tilt((row[6], row[7], row[8], row[9]))
    rate = (row[10], row[11], row[12])
    tx, ty, tz = attitude_torque(attitude, rate, torque_now, (roll, pitch, yaw_rate), body)
    frame = (body[4, 0], body[4, 1], body[4, 2])
    allocate((thrust, tx, ty, tz), frame, True, wanted)  # noqa: FBT003  numba takes no keywords here


def _push(row: Array, push: Three, body: Array) -> None:
    """Integrate velocity and position over one step."""
    x, y, z, w = row[6], row[7], row[8], row[9]
    lift = (row[13] + row[14] + row[15] + row[16]) / body[5, 0]
    h = body[5, 2]
    row[17] = lift * 2.0 * (x * z + w * y) + push[0]
    row[18] = lift * 2.0 * (y * z - w * x) + push[1]
    row[19] = lift * (1.0 - 2.0 * (x * x + y * y)) - GRAVITY + push[2]
    for k in range(3):
        before = row[3 + k]
        row[3 + k] = before + row[17 + k] * h
        row[k] += 0.5 * (before + row[3 + k]) * h


def _half_turn(square: float) -> tuple[float, float]:
    """Return sin x / x and cos x for x^2 = square; below 1e-3 the series are exact to the last digit."""
    if square > 1e-3:
        x = math.sqrt(square)
        return math.sin(x) / x, math.cos(x)
    sine = 1.0 - square * (1.0 / 6.0 - square * (1.0 / 120.0 - square * (1.0 / 5040.0)))
    rest = 1.0 / 24.0 - square * (1.0 / 720.0 - square * (1.0 / 40320.0))
    return sine, 1.0 - square * (0.5 - square * rest)


def _turn(row: Array, body: Array) -> None:
    """Integrate angular velocity and attitude over one step."""
    tx, ty, tz = torque((row[13], row[14], row[15], row[16]), body[4, 0], body[4, 1])
    ix, iy, iz, h = body[2, 0], body[2, 1], body[2, 2], body[5, 2]
    p, q, r = row[10], row[11], row[12]
    wx = p + h * (tx + (iy - iz) * q * r) / ix
    wy = q + h * (ty + (iz - ix) * p * r) / iy
    wz = r + h * (tz + (ix - iy) * p * q) / iz
    row[10], row[11], row[12] = wx, wy, wz
    s, c = half_turn(0.25 * h * h * (wx * wx + wy * wy + wz * wz))
    s *= 0.5 * h
    ex, ey, ez = s * wx, s * wy, s * wz
    x, y, z, w = row[6], row[7], row[8], row[9]
    nx = w * ex + x * c + y * ez - z * ey
    ny = w * ey - x * ez + y * c + z * ex
    nz = w * ez + x * ey - y * ex + z * c
    nw = w * c - x * ex - y * ey - z * ez
    scale = 1.5 - 0.5 * (nx * nx + ny * ny + nz * nz + nw * nw)  # 1 / sqrt near 1, by Newton
    row[6], row[7], row[8], row[9] = nx * scale, ny * scale, nz * scale, nw * scale


def _stand(row: Array, body: Array) -> None:
    """Stop a vehicle below the ground, level, with its yaw kept; acc includes the ground's reaction."""
    for k in range(3):
        after = max(row[5], 0.0) if k == 2 else 0.0
        row[17 + k] += (after - row[3 + k]) / body[5, 2]
        row[3 + k] = after
        row[10 + k] = 0.0
    row[2] = 0.0
    x, y, z, w = row[6], row[7], row[8], row[9]
    half_yaw = 0.5 * math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    row[6], row[7], row[8], row[9] = 0.0, 0.0, math.sin(half_yaw), math.cos(half_yaw)


def _advance(row: Array, command: Four, drive: Array, body: Array, wanted: Array) -> None:
    onboard(row, command, body, wanted)
    for k in range(4):
        target = drive[3 + k] * wanted[k]
        row[13 + k] = target + (row[13 + k] - target) * body[5, 1]
    push(row, (drive[0], drive[1], drive[2] + row[20]), body)
    turn(row, body)
    if row[2] < 0.0:
        stand(row, body)


part = partial(compiled, inline="always")
half_turn, torque, tilt, onboard = part(_half_turn), part(_torque), part(_tilt), part(_wanted)
push, turn, stand = part(_push), part(_turn), compiled(_stand)
advance = compiled(_advance)
"""Move one vehicle by a step: state row (21,), command (thrust, roll, pitch, yaw rate), drive (7,), body
(6, 3), room for wanted rotor thrusts (4,)."""
