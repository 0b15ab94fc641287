"""The firmware's Mellinger controller, at 500 Hz, compiled.

Source: firmware: modules/src/controller/controller_mellinger.c, after Mellinger, Kumar, Minimum snap
trajectory generation and control for quadrotors, ICRA 2011, with integrals and a derivative of the rates.

    F    = m (a_ref + g e_z) + k_p (r_ref - r) + k_d (v_ref - v) + k_i int(r_ref - r)        position known
    F    = m g e_z + the same, z only                                                 velocity setpoints
    T    = massThrust F . z_B                    [PWM]; thrust of the setpoint if z is not controlled
    z_d  = F / |F|,  y_d = z_d x (cos psi, sin psi, 0) / |..|,  x_d = y_d x z_d
    e_R  = vee(R_d' R - R' R_d),  e_w = w_ref - w
    M    = -k_R e_R + k_w e_w + k_i int(-e_R) + k_d,omega d(e_w)/dt     [PWM], integer, within +-32000

a_ref is the acceleration of the setpoint: `acc = acc_ref - eta` compensates the downwash eta in F, as in
q2q_control.pid.pid. M is in the firmware's axes: roll right, nose *up*, and yaw left; control yaw is -M_z,
since motors 1 and 3 turn left and drag the body right.

Rows are those of one vehicle: `row` of state_row.py; `setpoint`, `gains`, `memory`, `drift` of columns.py.

| symbol | name | meaning [unit] |
|---|---|---|
| m | MASS | ctrlMel.mass [kg] |
| k_p k_d k_i | KP KD KI | [N/m], [N s/m], [N/(m s)] |
| k_R k_w | KR KW | [PWM], [PWM s] |
"""

import math

from q2q_model.compiled import compiled
from q2q_model.geometry.yaw import yaw_of
from q2q_model.signals.values import Array, Three
from q2q_model.vehicle.constants import GRAVITY
from q2q_sim.firmware.controllers.attitude_pid import DT
from q2q_sim.firmware.controllers.columns import (
    ABS,
    CONTROL,
    DISABLE,
    I_MOMENT,
    I_POS,
    I_RANGE_M_XY,
    I_RANGE_M_Z,
    I_RANGE_XY,
    I_RANGE_Z,
    KD_OMEGA,
    KD_XY,
    KD_Z,
    KI_M_XY,
    KI_M_Z,
    KI_XY,
    KI_Z,
    KP_XY,
    KP_Z,
    KR_XY,
    KR_Z,
    KW_XY,
    KW_Z,
    LAST_RATE,
    LAST_SET_RATE,
    MASS,
    MASS_THRUST,
    MODE_PITCH,
    MODE_QUAT,
    MODE_ROLL,
    MODE_X,
    MODE_YAW,
    MODE_Z,
    SET_ACC,
    SET_ATTITUDE,
    SET_POS,
    SET_QUAT,
    SET_RATE,
    SET_THRUST,
    SET_VEL,
    VELOCITY,
    Z_AXIS_SETPOINT,
)
from q2q_sim.firmware.controllers.state_attitude import Nine, axes, legacy_degrees
from q2q_sim.firmware.controllers.truncation import truncate
from q2q_sim.plant.body.state_row import VX, VY, VZ, P, Q, R, X, Y, Z

MOMENT_MAX = 32000.0
"""Largest moment [PWM]."""
RAD = math.pi / 180.0


@compiled
def clamp(value: float, limit: float) -> float:
    """Return a value within +-limit."""
    return min(max(value, -limit), limit)


@compiled
def force_of(row: Array, drift: Array, setpoint: Array, gains: Array, memory: Array) -> Three:
    """Return F [N], world, and update the integrals of position."""
    ex = setpoint[SET_POS] - row[X] - drift[0]
    ey = setpoint[SET_POS + 1] - row[Y] - drift[1]
    ez = setpoint[SET_POS + 2] - row[Z] - drift[2]
    memory[I_POS] = clamp(memory[I_POS] + ex * DT, gains[I_RANGE_XY])
    memory[I_POS + 1] = clamp(memory[I_POS + 1] + ey * DT, gains[I_RANGE_XY])
    memory[I_POS + 2] = clamp(memory[I_POS + 2] + ez * DT, gains[I_RANGE_Z])
    fz = (
        gains[KP_Z] * ez
        + gains[KD_Z] * (setpoint[SET_VEL + 2] - row[VZ] - drift[5])
        + gains[KI_Z] * memory[I_POS + 2]
    )
    if setpoint[MODE_X] != ABS:
        return 0.0, 0.0, gains[MASS] * GRAVITY + fz
    fx = (
        gains[KP_XY] * ex
        + gains[KD_XY] * (setpoint[SET_VEL] - row[VX] - drift[3])
        + gains[KI_XY] * memory[I_POS]
    )
    fy = gains[KP_XY] * ey + gains[KD_XY] * (setpoint[SET_VEL + 1] - row[VY] - drift[4])
    fy += gains[KI_XY] * memory[I_POS + 1]
    mass = gains[MASS]
    return (
        mass * setpoint[SET_ACC] + fx,
        mass * setpoint[SET_ACC + 1] + fy,
        mass * (setpoint[SET_ACC + 2] + GRAVITY) + fz,
    )


@compiled
def yaw_setpoint(row: Array, setpoint: Array) -> float:
    """Return the yaw setpoint psi [rad]."""
    if setpoint[MODE_YAW] == VELOCITY:
        return float(legacy_degrees(row)[2] * RAD + setpoint[SET_RATE + 2] * RAD * DT)
    if setpoint[MODE_YAW] == ABS:
        return float(setpoint[SET_ATTITUDE + 2] * RAD)
    if setpoint[MODE_QUAT] == ABS:
        q = SET_QUAT
        return float(yaw_of(setpoint[q], setpoint[q + 1], setpoint[q + 2], setpoint[q + 3]))
    return 0.0


@compiled
def frame_along(z: Three, yaw: float) -> Nine:
    """Return x_d, y_d, z_d, world, for a unit z axis and a yaw [rad]."""
    zx, zy, zz = z
    cx, cy = math.cos(yaw), math.sin(yaw)
    yx, yy, yz = -zz * cy, zz * cx, zx * cy - zy * cx
    length = math.sqrt(yx * yx + yy * yy + yz * yz)
    if length < 1e-9:  # thrust along the nose: y is arbitrary
        return 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, zx, zy, zz
    yx, yy, yz = yx / length, yy / length, yz / length
    return yy * zz - yz * zy, yz * zx - yx * zz, yx * zy - yy * zx, yx, yy, yz, zx, zy, zz


@compiled
def frame_of_angles(roll: float, pitch: float, yaw: float) -> Nine:
    """Return body x, y, z, world, at Euler angles [rad], Z-Y-X."""
    cr, sr, cp, sp = math.cos(roll), math.sin(roll), math.cos(pitch), math.sin(pitch)
    cy, sy = math.cos(yaw), math.sin(yaw)
    return (
        cp * cy, cp * sy, -sp,
        sr * sp * cy - cr * sy, sr * sp * sy + cr * cy, sr * cp,
        cr * sp * cy + sr * sy, cr * sp * sy - sr * cy, cr * cp,
    )  # fmt: skip


@compiled
def dot(frame: Nine, i: int, body: Nine, j: int) -> float:
    """Return the scalar product of axis i of one frame and axis j of another, x y z as 0 1 2."""
    return (
        frame[3 * i] * body[3 * j] + frame[3 * i + 1] * body[3 * j + 1] + frame[3 * i + 2] * body[3 * j + 2]
    )


@compiled
def moments(row: Array, setpoint: Array, gains: Array, memory: Array, frame: Nine) -> Three:
    """Return M [PWM]: roll right, nose up, yaw left; update the integrals of moments and the last rates.

    `frame` is x_d, y_d, z_d.
    """
    body = axes(row)
    ex = dot(frame, 2, body, 1) - dot(frame, 1, body, 2)
    ey = -(dot(frame, 0, body, 2) - dot(frame, 2, body, 0))  # nose up
    ez = dot(frame, 1, body, 0) - dot(frame, 0, body, 1)
    set_roll, set_up, set_yaw = (
        setpoint[SET_RATE] * RAD,
        -setpoint[SET_RATE + 1] * RAD,
        setpoint[SET_RATE + 2] * RAD,
    )
    roll_rate, up_rate, yaw_rate = row[P], -row[Q], row[R]
    jerk_x = ((set_roll - memory[LAST_SET_RATE]) - (roll_rate - memory[LAST_RATE])) / DT
    jerk_y = ((set_up - memory[LAST_SET_RATE + 1]) - (up_rate - memory[LAST_RATE + 1])) / DT
    memory[LAST_RATE], memory[LAST_RATE + 1] = roll_rate, up_rate
    memory[LAST_SET_RATE], memory[LAST_SET_RATE + 1] = set_roll, set_up
    memory[I_MOMENT] = clamp(memory[I_MOMENT] - ex * DT, gains[I_RANGE_M_XY])
    memory[I_MOMENT + 1] = clamp(memory[I_MOMENT + 1] - ey * DT, gains[I_RANGE_M_XY])
    memory[I_MOMENT + 2] = clamp(memory[I_MOMENT + 2] - ez * DT, gains[I_RANGE_M_Z])
    mx = -gains[KR_XY] * ex + gains[KW_XY] * (set_roll - roll_rate) + gains[KI_M_XY] * memory[I_MOMENT]
    my = -gains[KR_XY] * ey + gains[KW_XY] * (set_up - up_rate) + gains[KI_M_XY] * memory[I_MOMENT + 1]
    mz = -gains[KR_Z] * ez + gains[KW_Z] * (set_yaw - yaw_rate) + gains[KI_M_Z] * memory[I_MOMENT + 2]
    return mx + gains[KD_OMEGA] * jerk_x, my + gains[KD_OMEGA] * jerk_y, mz


@compiled
def mellinger(row: Array, drift: Array, setpoint: Array, gains: Array, memory: Array) -> None:
    """Write the control outputs [PWM] of one vehicle for one step."""
    force = force_of(row, drift, setpoint, gains, memory)
    yaw = yaw_setpoint(row, setpoint)
    length = max(math.sqrt(force[0] ** 2 + force[1] ** 2 + force[2] ** 2), 1e-9)
    along = (force[0] / length, force[1] / length, force[2] / length)
    attitude_only = setpoint[MODE_X] != ABS and setpoint[MODE_ROLL] == ABS and setpoint[MODE_PITCH] == ABS
    if attitude_only and setpoint[MODE_Z] == DISABLE:
        a = SET_ATTITUDE
        frame = frame_of_angles(setpoint[a] * RAD, -setpoint[a + 1] * RAD, yaw)
    elif setpoint[MODE_X] != ABS:
        frame = frame_along(along, legacy_degrees(row)[2] * RAD)
    else:
        frame = frame_along(along, yaw)
    mx, my, mz = moments(row, setpoint, gains, memory, frame)
    body = axes(row)
    thrust = gains[MASS_THRUST] * (force[0] * body[6] + force[1] * body[7] + force[2] * body[8])
    if setpoint[MODE_Z] == DISABLE:
        thrust = setpoint[SET_THRUST]
    memory[Z_AXIS_SETPOINT], memory[Z_AXIS_SETPOINT + 1], memory[Z_AXIS_SETPOINT + 2] = (
        frame[6],
        frame[7],
        frame[8],
    )
    memory[CONTROL + 3] = thrust
    if thrust > 0.0:
        memory[CONTROL], memory[CONTROL + 1] = truncate(mx, MOMENT_MAX), truncate(my, MOMENT_MAX)
        memory[CONTROL + 2] = truncate(-mz, MOMENT_MAX)
        return
    memory[CONTROL : CONTROL + 3] = 0.0
    memory[I_POS : I_MOMENT + 3] = 0.0
