"""Attitude and rate loops of the firmware's default controller (PID), at 500 Hz, compiled.

Source: firmware: modules/src/controller/controller_pid.c, attitude_pid_controller.c. All in degrees, pitch
nose up:

    rate_d  = PID(attitude)         roll and pitch from the position loop or the setpoint
    control = PID(rate) [PWM], integer, within +-32767; sign of yaw inverted (motors 1 and 3 turn left)

The yaw setpoint integrates a yaw-rate setpoint. The PIDs are reset when a mode changes, and hold at thrust 0.
Rows are those of one vehicle: `row` of state_row.py; `setpoint`, `gains`, `memory`, `drift` of columns.py.
"""

from q2q_model.compiled import compiled
from q2q_model.geometry.yaw import yaw_of
from q2q_model.signals.values import Array, Three
from q2q_sim.firmware.controllers.columns import (
    ABS,
    ATTITUDE_GAINS,
    ATTITUDE_SETPOINT,
    CONTROL,
    DISABLE,
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
    RATE_SETPOINT,
    SET_ATTITUDE,
    SET_QUAT,
    SET_RATE,
    SET_THRUST,
    THRUST_SETPOINT,
    VELOCITY,
)
from q2q_sim.firmware.controllers.pid_step import PidColumns, pid, pid_reset, slope_of
from q2q_sim.firmware.controllers.position_pid import position_pid
from q2q_sim.firmware.controllers.state_attitude import DEG, legacy_degrees
from q2q_sim.firmware.controllers.truncation import INT16_MAX, truncate
from q2q_sim.plant.body.state_row import P, Q, R

DT = 1.0 / 500.0
"""ATTITUDE_RATE of the firmware [s]."""
ANGLE_INTEGRAL, YAW_INTEGRAL = 20.0, 360.0
"""PID_ROLL_INTEGRATION_LIMIT, PID_YAW_INTEGRATION_LIMIT, platform_defaults_cf2.h."""
RATE_INTEGRAL, YAW_RATE_INTEGRAL = 33.3, 166.7
"""PID_ROLL_RATE_INTEGRATION_LIMIT, PID_YAW_RATE_INTEGRATION_LIMIT, the same."""


@compiled
def wrap_degrees(angle: float) -> float:
    """Return an angle [deg] within +-180 deg, both ends included."""
    return angle if abs(angle) <= 180.0 else (angle + 180.0) % 360.0 - 180.0


@compiled
def restart(row: Array, drift: Array, memory: Array, attitude: Three) -> None:
    """Reset the PIDs of position and attitude at their measurements, the others at 0.

    `attitude` is roll, legacy pitch, yaw [deg]; the first two become setpoints.
    """
    for k in range(12):
        pid_reset(memory, PIDS + PID_WIDTH * k, 0.0)
    for k in range(3):
        memory[PIDS + PID_WIDTH * k + 1] = row[k] + drift[k]
        memory[PIDS + PID_WIDTH * (PID_ROLL + k) + 1] = attitude[k]
    memory[ATTITUDE_SETPOINT], memory[ATTITUDE_SETPOINT + 1] = attitude[0], attitude[1]


@compiled
def mode_changed(setpoint: Array, memory: Array) -> bool:
    """Return whether one of the seven modes differs from the last step's, and store the modes."""
    changed = False
    for k in range(7):
        changed = changed or setpoint[k] != memory[LAST_MODES + k]
        memory[LAST_MODES + k] = setpoint[k]
    return changed


@compiled
def move_yaw(setpoint: Array, memory: Array) -> None:
    """Write the yaw setpoint [deg]: integrated, absolute, or of a quaternion."""
    yaw = memory[ATTITUDE_SETPOINT + 2]
    if setpoint[MODE_YAW] == VELOCITY:
        yaw += setpoint[SET_RATE + 2] * DT
    elif setpoint[MODE_YAW] == ABS:
        yaw = setpoint[SET_ATTITUDE + 2]
    elif setpoint[MODE_QUAT] == ABS:
        q = SET_QUAT
        yaw = DEG * yaw_of(setpoint[q], setpoint[q + 1], setpoint[q + 2], setpoint[q + 3])
    memory[ATTITUDE_SETPOINT + 2] = wrap_degrees(yaw)


@compiled
def attitude_loop(attitude: Three, memory: Array, gains: Array) -> None:
    """Write the rate setpoints [deg/s]; `attitude` is roll, legacy pitch, yaw [deg]."""
    for k in range(3):
        at = PIDS + PID_WIDTH * (PID_ROLL + k)
        error, limit = memory[ATTITUDE_SETPOINT + k] - attitude[k], ANGLE_INTEGRAL
        rise = slope_of(memory, at, attitude[k], DT)
        if k == 2:
            error, limit, rise = wrap_degrees(error), YAW_INTEGRAL, wrap_degrees(rise * DT) / DT
        memory[RATE_SETPOINT + k] = pid(
            error, rise, memory, gains, PidColumns(at, ATTITUDE_GAINS + 3 * k, DT, limit)
        )


@compiled
def rate_loop(row: Array, memory: Array, gains: Array) -> None:
    """Write the control outputs of roll, legacy pitch, yaw [PWM]."""
    rates = (DEG * row[P], -DEG * row[Q], DEG * row[R])
    for k in range(3):
        at = PIDS + PID_WIDTH * (PID_ROLL_RATE + k)
        limit = YAW_RATE_INTEGRAL if k == 2 else RATE_INTEGRAL
        rise = slope_of(memory, at, rates[k], DT)
        columns = PidColumns(at, RATE_GAINS + 3 * k, DT, limit)
        memory[CONTROL + k] = truncate(
            pid(memory[RATE_SETPOINT + k] - rates[k], rise, memory, gains, columns), INT16_MAX
        )
    memory[CONTROL + 2] = -memory[CONTROL + 2]


@compiled
def cascade(tick: tuple[Array, Array, Array], gains: Array, memory: Array, position_due: bool) -> None:
    """Write the control outputs [PWM] of one vehicle for one step; `tick` is its row, drift and setpoint.

    The position loop runs where `position_due`.
    """
    row, drift, setpoint = tick
    attitude = legacy_degrees(row)
    if mode_changed(setpoint, memory):
        restart(row, drift, memory, attitude)
    move_yaw(setpoint, memory)
    if position_due:
        position_pid(row, drift, setpoint, gains, memory)
    if setpoint[MODE_Z] == DISABLE:
        memory[THRUST_SETPOINT] = setpoint[SET_THRUST]
    if setpoint[MODE_X] == DISABLE or setpoint[MODE_Y] == DISABLE:
        memory[ATTITUDE_SETPOINT], memory[ATTITUDE_SETPOINT + 1] = (
            setpoint[SET_ATTITUDE],
            setpoint[SET_ATTITUDE + 1],
        )
    attitude_loop(attitude, memory, gains)
    if setpoint[MODE_ROLL] == VELOCITY:
        memory[RATE_SETPOINT] = setpoint[SET_RATE]
    if setpoint[MODE_PITCH] == VELOCITY:
        memory[RATE_SETPOINT + 1] = setpoint[SET_RATE + 1]
    rate_loop(row, memory, gains)
    memory[CONTROL + 3] = memory[THRUST_SETPOINT]
    if memory[CONTROL + 3] == 0.0:
        memory[CONTROL : CONTROL + 3] = 0.0
        restart(row, drift, memory, attitude)
        memory[ATTITUDE_SETPOINT + 2] = attitude[2]
