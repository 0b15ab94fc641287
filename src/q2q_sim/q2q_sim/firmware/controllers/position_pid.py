"""Position and velocity loops of the firmware's default controller (PID), at 100 Hz, compiled.

Source: firmware: modules/src/controller/position_controller_pid.c.

    v_d     = PID(position), in the frame rotated by the yaw, |v| <= 1.1 velMax       axes with absolute mode
    pitch_d = -PID(v_x) [deg, legacy: nose down is forward],  roll_d = -PID(v_y)      within rLimit, pLimit
    T       = 1000 PID(v_z) + thrustBase [PWM], at least thrustMin

Each of the three inner PIDs adds its feed-forward, KFF v_d. The controller reads no
acceleration: `acc` of a full state does nothing under this controller.
Rows are those of one vehicle: `row` of state_row.py; `setpoint`, `gains`, `memory`, `drift` of columns.py.
"""

import math
from typing import NamedTuple

from q2q_model.compiled import compiled
from q2q_model.geometry.yaw import yaw_of
from q2q_model.signals.values import Array, Three
from q2q_sim.firmware.controllers.columns import (
    ABS,
    ATTITUDE_SETPOINT,
    MODE_X,
    MODE_Y,
    MODE_Z,
    PID_VX,
    PID_WIDTH,
    PID_X,
    PIDS,
    PITCH_LIMIT,
    POS_GAINS,
    POS_TARGET,
    ROLL_LIMIT,
    SET_BODY,
    SET_POS,
    SET_VEL,
    THRUST_BASE,
    THRUST_MIN,
    THRUST_SETPOINT,
    VEL_FEED,
    VEL_GAINS,
    VEL_MAX,
    VEL_TARGET,
)
from q2q_sim.firmware.controllers.pid_step import INTEGRAL_LIMIT, PidColumns, filtered, pid, slope_of
from q2q_sim.firmware.motors.thrust_curve import PWM_TOP
from q2q_sim.plant.body.state_row import QW, QX, QY, QZ, VX, VY, VZ, X, Y, Z

DT = 1.0 / 100.0
"""POSITION_RATE of the firmware [s]."""
OVERHEAD = 1.1
"""velMaxOverhead, rpLimitOverhead."""
THRUST_SCALE = 1000.0
LIFT_MAX = 32.767
"""Half of UINT16_MAX, truncated, over the thrust scale."""


class FilteredPid(NamedTuple):
    """One of the PIDs of position and velocity."""

    number: int
    gains: int
    """First column of its gains."""
    output_max: float
    """With the feed-forward; 0: no limit."""
    feed: float
    """Feed-forward."""


@compiled
def axis(error: float, measured: float, memory: Array, gains: Array, one: FilteredPid) -> float:
    """Return the output of one filtered PID and its feed-forward, together within +-output_max."""
    at, top = PIDS + PID_WIDTH * one.number, one.output_max
    rise = filtered(memory, at, slope_of(memory, at, measured, DT))
    out = pid(error, rise, memory, gains, PidColumns(at, one.gains, DT, INTEGRAL_LIMIT)) + one.feed
    return float(min(max(out, -top), top) if top > 0.0 else out)


@compiled
def velocity_setpoint(
    where: Three, setpoint: Array, gains: Array, memory: Array, turn: tuple[float, float]
) -> Three:
    """Return v_d forward, left, up [m/s].

    `where` is the estimated position [m], world, and `turn` cos, sin of the yaw.
    """
    c, s = turn
    p, v = SET_POS, SET_VEL
    ahead, left = where[0] * c + where[1] * s, where[1] * c - where[0] * s
    vx, vy, vz = setpoint[v], setpoint[v + 1], setpoint[v + 2]
    if setpoint[SET_BODY] == 0.0:
        vx, vy = setpoint[v] * c + setpoint[v + 1] * s, setpoint[v + 1] * c - setpoint[v] * s
    if setpoint[MODE_X] == ABS:
        memory[POS_TARGET] = setpoint[p] * c + setpoint[p + 1] * s
        error = memory[POS_TARGET] - ahead
        vx = axis(error, ahead, memory, gains, FilteredPid(PID_X, POS_GAINS, OVERHEAD * gains[VEL_MAX], 0.0))
    if setpoint[MODE_Y] == ABS:
        memory[POS_TARGET + 1] = setpoint[p + 1] * c - setpoint[p] * s
        error = memory[POS_TARGET + 1] - left
        vy = axis(
            error,
            left,
            memory,
            gains,
            FilteredPid(PID_X + 1, POS_GAINS + 3, OVERHEAD * gains[VEL_MAX + 1], 0.0),
        )
    if setpoint[MODE_Z] == ABS:
        memory[POS_TARGET + 2] = setpoint[p + 2]
        error, top = setpoint[p + 2] - where[2], OVERHEAD * max(gains[VEL_MAX + 2], 0.5)
        vz = axis(error, where[2], memory, gains, FilteredPid(PID_X + 2, POS_GAINS + 6, top, 0.0))
    return vx, vy, vz


@compiled
def position_pid(row: Array, drift: Array, setpoint: Array, gains: Array, memory: Array) -> None:
    """Write the setpoints of roll and legacy pitch [deg], and of thrust [PWM]."""
    yaw = yaw_of(row[QX], row[QY], row[QZ], row[QW])
    c, s = math.cos(yaw), math.sin(yaw)
    where = (row[X] + drift[0], row[Y] + drift[1], row[Z] + drift[2])
    vel_x, vel_y, vel_z = row[VX] + drift[3], row[VY] + drift[4], row[VZ] + drift[5]
    ahead, left = vel_x * c + vel_y * s, vel_y * c - vel_x * s
    vx, vy, vz = velocity_setpoint(where, setpoint, gains, memory, (c, s))
    memory[VEL_TARGET], memory[VEL_TARGET + 1], memory[VEL_TARGET + 2] = vx, vy, vz
    feed = gains[VEL_FEED] * vx, gains[VEL_FEED + 1] * vy, gains[VEL_FEED + 2] * vz
    pitch_max, roll_max = gains[PITCH_LIMIT], gains[ROLL_LIMIT]
    pitch = -axis(
        vx - ahead, ahead, memory, gains, FilteredPid(PID_VX, VEL_GAINS, OVERHEAD * pitch_max, feed[0])
    )
    roll = -axis(
        vy - left, left, memory, gains, FilteredPid(PID_VX + 1, VEL_GAINS + 3, OVERHEAD * roll_max, feed[1])
    )
    lift = axis(vz - vel_z, vel_z, memory, gains, FilteredPid(PID_VX + 2, VEL_GAINS + 6, LIFT_MAX, feed[2]))
    memory[ATTITUDE_SETPOINT] = min(max(roll, -roll_max), roll_max)
    memory[ATTITUDE_SETPOINT + 1] = min(max(pitch, -pitch_max), pitch_max)
    thrust = max(THRUST_SCALE * lift + gains[THRUST_BASE], gains[THRUST_MIN])
    memory[THRUST_SETPOINT] = min(thrust, PWM_TOP)
