"""Attitude and rate loops of the firmware's default controller (PID), at 500 Hz, compiled.

Source: firmware: modules/src/controller/controller_pid.c, attitude_pid_controller.c. All in degrees, pitch
nose up:

    rate_d  = PID(attitude)         roll and pitch from the position loop or the setpoint
    control = PID(rate) [PWM], integer, within +-32767; sign of yaw inverted (motors 1 and 3 turn left)

The yaw setpoint integrates a yaw-rate setpoint. The PIDs are reset when a mode changes, and hold at thrust 0.
"""

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array
from q2q_sim.firmware.commander.setpoint import Three
from q2q_sim.firmware.controllers.attitude_of import DEG, legacy_degrees, yaw_of
from q2q_sim.firmware.controllers.columns import (
    ATTITUDE_GAINS,
    ATTITUDE_WANTED,
    CONTROL,
    LAST_MODES,
    MODE_PITCH,
    MODE_QUAT,
    MODE_ROLL,
    MODE_X,
    MODE_Y,
    MODE_YAW,
    MODE_Z,
    PID_ROLL,
    PID_ROLL_RATE,
    PID_WIDTH,
    PIDS,
    RATE_GAINS,
    RATE_WANTED,
    SET_ATTITUDE,
    SET_QUAT,
    SET_RATE,
    SET_THRUST,
    THRUST_WANTED,
)
from q2q_sim.firmware.controllers.pid_step import pid, pid_reset, slope_of
from q2q_sim.firmware.controllers.position_pid import position_pid
from q2q_sim.firmware.controllers.truncation import INT16_MAX, whole

DT = 1.0 / 500.0
"""ATTITUDE_RATE of the firmware [s]."""
ANGLE_INTEGRAL, YAW_INTEGRAL = 20.0, 360.0
"""PID_ROLL_INTEGRATION_LIMIT, PID_YAW_INTEGRATION_LIMIT, platform_defaults_cf2.h."""
RATE_INTEGRAL, YAW_RATE_INTEGRAL = 33.3, 166.7
"""PID_ROLL_RATE_INTEGRATION_LIMIT, PID_YAW_RATE_INTEGRATION_LIMIT, the same."""


def _wrapped(angle: float) -> float:
    """Return an angle within +-180 deg, both ends included."""
    return angle if abs(angle) <= 180.0 else (angle + 180.0) % 360.0 - 180.0


def _restart(row: Array, drift: Array, memory: Array, attitude: Three) -> None:
    for k in range(12):
        pid_reset(memory, PIDS + PID_WIDTH * k, 0.0)
    for k in range(3):
        memory[PIDS + PID_WIDTH * k + 1] = row[k] + drift[k]
        memory[PIDS + PID_WIDTH * (PID_ROLL + k) + 1] = attitude[k]
    memory[ATTITUDE_WANTED], memory[ATTITUDE_WANTED + 1] = attitude[0], attitude[1]


def _mode_changed(wanted: Array, memory: Array) -> bool:
    changed = False
    for k in range(7):
        changed = changed or wanted[k] != memory[LAST_MODES + k]
        memory[LAST_MODES + k] = wanted[k]
    return changed


def _move_yaw(wanted: Array, memory: Array) -> None:
    yaw = memory[ATTITUDE_WANTED + 2]
    if wanted[MODE_YAW] == 2.0:
        yaw += wanted[SET_RATE + 2] * DT
    elif wanted[MODE_YAW] == 1.0:
        yaw = wanted[SET_ATTITUDE + 2]
    elif wanted[MODE_QUAT] == 1.0:
        q = SET_QUAT
        yaw = DEG * yaw_of(wanted[q], wanted[q + 1], wanted[q + 2], wanted[q + 3])
    memory[ATTITUDE_WANTED + 2] = wrapped(yaw)


def _attitude_loop(attitude: Three, memory: Array, gains: Array) -> None:
    """Write the rate setpoints."""
    for k in range(3):
        at = PIDS + PID_WIDTH * (PID_ROLL + k)
        error, limit = memory[ATTITUDE_WANTED + k] - attitude[k], ANGLE_INTEGRAL
        rise = slope_of(memory, at, attitude[k], DT)
        if k == 2:
            error, limit, rise = wrapped(error), YAW_INTEGRAL, wrapped(rise * DT) / DT
        memory[RATE_WANTED + k] = pid(
            error, rise, memory, gains, (at, ATTITUDE_GAINS + 3 * k, DT, limit, 0.0)
        )


def _rate_loop(row: Array, memory: Array, gains: Array) -> None:
    """Write the control outputs [PWM]."""
    rates = (DEG * row[10], -DEG * row[11], DEG * row[12])
    for k in range(3):
        at = PIDS + PID_WIDTH * (PID_ROLL_RATE + k)
        limit = YAW_RATE_INTEGRAL if k == 2 else RATE_INTEGRAL
        rise = slope_of(memory, at, rates[k], DT)
        how = (at, RATE_GAINS + 3 * k, DT, limit, 0.0)
        memory[CONTROL + k] = whole(
            pid(memory[RATE_WANTED + k] - rates[k], rise, memory, gains, how), INT16_MAX
        )
    memory[CONTROL + 2] = -memory[CONTROL + 2]


def _cascade(tick: tuple[Array, Array, Array], gains: Array, memory: Array, position_due: bool) -> None:
    row, drift, wanted = tick
    attitude = legacy_degrees(row)
    if mode_changed(wanted, memory):
        restart(row, drift, memory, attitude)
    move_yaw(wanted, memory)
    if position_due:
        position_pid(row, drift, wanted, gains, memory)
    if wanted[MODE_Z] == 0.0:
        memory[THRUST_WANTED] = wanted[SET_THRUST]
    if wanted[MODE_X] == 0.0 or wanted[MODE_Y] == 0.0:
        memory[ATTITUDE_WANTED], memory[ATTITUDE_WANTED + 1] = wanted[SET_ATTITUDE], wanted[SET_ATTITUDE + 1]
    attitude_loop(attitude, memory, gains)
    if wanted[MODE_ROLL] == 2.0:
        memory[RATE_WANTED] = wanted[SET_RATE]
    if wanted[MODE_PITCH] == 2.0:
        memory[RATE_WANTED + 1] = wanted[SET_RATE + 1]
    rate_loop(row, memory, gains)
    memory[CONTROL + 3] = memory[THRUST_WANTED]
    if memory[CONTROL + 3] == 0.0:
        memory[CONTROL : CONTROL + 3] = 0.0
        restart(row, drift, memory, attitude)
        memory[ATTITUDE_WANTED + 2] = attitude[2]


wrapped, restart = compiled(_wrapped), compiled(_restart)
mode_changed, move_yaw = compiled(_mode_changed), compiled(_move_yaw)
attitude_loop, rate_loop = compiled(_attitude_loop), compiled(_rate_loop)
cascade = compiled(_cascade)
"""Control one vehicle for one step: ((state row, drift, wanted), gains, memory, whether the position loop is
due); writes the outputs in memory."""
