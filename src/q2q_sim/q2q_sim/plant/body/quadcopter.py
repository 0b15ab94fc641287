"""Physics step of one quadcopter: rigid body, rotor lag, onboard attitude loop, ground.

The equations are (1)-(9) in quaternion form, without small angles, and without the gyroscopic torque of the
rotors, whose signed sum of speeds Omega_r is near 0:

    v'  = -g e_z + T / m R(q) e_z + eta + a_air        T = f1 + f2 + f3 + f4
    I w' = tau + tau_air - w x (I w)                   tau from the rotors (q2q_control.attitude.allocation)
    q'  = q (w, 0) / 2
    f'  = (k f_g - f) / T_lag                          f_g from f_c, every step

One step of h: the rotor lag is exact for a constant command; v uses T of the new rotors and R of the old
attitude; position advances by the mean of old and new velocity, which is exact for constant acceleration;
w is integrated first, then q by exp(w h) (semi-implicit). The ground is at z = 0: there the vehicle stops,
level, with its yaw kept, and stays, whatever the wind. A commanded thrust of zero stops the motors, as in
the firmware.

| symbol | name | meaning [unit] |
|---|---|---|
| f | rotors | thrust of each rotor [N] |
| f_c | | thrusts that attitude law and allocation command of the rotors [N] |
| f_g | | of f_c what rotors of limits f_max give together (rotors.py) [N] |
| f_max | rotor_max | largest thrust of a rotor [N] |
| k | gain | thrust over commanded thrust of a rotor: battery, wear [-] |
| T_lag | thrust_lag | [s]; decay = exp(-h / T_lag) |
| eta + a_air | push | acceleration by the air (downwash, ground) and by wind [m/s^2], world |
| tau_air | | torque of the air [N m], body |
| h | step | [s] |

The compiled loops hold one row of numbers for each vehicle, with the columns of state_row.
"""

import math
from typing import NamedTuple

from q2q_control.attitude.allocation import rotor_frame
from q2q_control.attitude.allocation_kernel import allocate, packed_frame
from q2q_control.attitude.attitude_law import (
    AttitudeGains,
    AttitudeParams,
    attitude_gains,
    attitude_torque,
)
from q2q_model.compiled import BORROWING, compiled
from q2q_model.geometry.yaw import yaw_of
from q2q_model.signals.values import Array, Four, Three
from q2q_model.vehicle.constants import Vehicle
from q2q_sim.plant.body.rigid_body import (
    acceleration,
    half_turn_of,
    half_turn_squared,
    quat_after,
    rate_after,
)
from q2q_sim.plant.body.rotors import excess_share, rotor_torque, share_given
from q2q_sim.plant.body.state_row import (
    AX,
    AY,
    AZ,
    ETA_X,
    ETA_Y,
    ETA_Z,
    F1,
    F2,
    F3,
    F4,
    QW,
    QX,
    QY,
    QZ,
    ROTOR_MAX1,
    ROTOR_MAX2,
    ROTOR_MAX3,
    ROTOR_MAX4,
    TX,
    TY,
    TZ,
    VX,
    VZ,
    P,
    Q,
    R,
    X,
    Y,
    Z,
)

GAIN1 = 3
"""Column of the first rotor's gain in a drive row, after the acceleration by wind [m/s^2]."""


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
    frame = packed_frame(rotor_frame(vehicle))
    return Body(attitude_gains(attitude, vehicle), frame, vehicle.mass, decay, step)


@compiled(**BORROWING)
def tilt(quat: Four) -> Three:
    """Return roll, pitch [rad] of a quaternion, and 0 for the yaw, which the attitude law does not read."""
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
    allocate((thrust, tx, ty, tz), body.frame, commanded)


@compiled(**BORROWING)
def _push(row: Array, push: Three, body: Body) -> None:
    """Integrate velocity and position over one step."""
    quat, rotors = (row[QX], row[QY], row[QZ], row[QW]), (row[F1], row[F2], row[F3], row[F4])
    row[AX], row[AY], row[AZ] = acceleration(quat, rotors, push, body.mass)
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
    half_turn = half_turn_of(half_turn_squared(rate, body.step))
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
def move(row: Array, commanded: Array, drive: Array, body: Body) -> None:
    """Advance rotors and rigid body of a `row` by one step under commanded rotor thrusts [N], (4,).

    `row` and `drive` are as in `advance`.
    """
    rotor_max = (row[ROTOR_MAX1], row[ROTOR_MAX2], row[ROTOR_MAX3], row[ROTOR_MAX4])
    asked = (commanded[0], commanded[1], commanded[2], commanded[3])
    lost = excess_share(asked, rotor_max)
    share = share_given(asked, rotor_max, lost)
    for k in range(4):
        target = drive[GAIN1 + k] * share * max(commanded[k] - lost, 0.0)
        row[F1 + k] = target + (row[F1 + k] - target) * body.decay
    before = (row[X], row[Y], row[Z])
    _push(row, (drive[X] + row[ETA_X], drive[Y] + row[ETA_Y], drive[Z] + row[ETA_Z]), body)
    _turn(row, body)
    if row[Z] < 0.0:
        _stand(row, body)
        if before[Z] == 0.0:  # it stood: neither wind nor push moves it
            row[X], row[Y] = before[X], before[Y]


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
