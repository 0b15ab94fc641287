"""Mixer: thrust and moments to motor PWM, PWM to duty, duty to forces, compiled.

Source: firmware: modules/src/power_distribution_quadrotor.c (legacy mode), stabilizer.c (controlMotors);
motors numbered as in q2q_control.attitude.allocation:

    m1 = T - r/2 + p/2 + y,  m2 = T - r/2 - p/2 - y,  m3 = T + r/2 - p/2 + y,  m4 = T + r/2 + p/2 - y
    d  = duty of m at the supply                                     thrust_curve
    d' = d - max(0, max d - 65535), at least the idle thrust

All intermediate values are integers: r/2, p/2, m and the duty are truncated. Factors of the airframe scale
r, p and y. The force of a motor follows from its duty and the true battery voltage, up to the airframe's
limit. `setpoint`, `memory` and `frame` are rows of one vehicle (columns.py).
"""

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array
from q2q_sim.firmware.controllers.columns import (
    BATTERY,
    CONTROL,
    IDLE,
    MOTOR,
    MOTOR_COMMAND,
    MOTORS_ON,
    NEWTON_PER_PWM,
    ROTOR_MAX,
    SHARE_TILT,
    SHARE_YAW,
    SUPPLY,
)
from q2q_sim.firmware.controllers.truncation import INT32_MAX, truncate
from q2q_sim.firmware.motors.thrust_curve import PWM_TOP, compensate, thrust_pwm


@compiled
def mix(memory: Array, frame: Array) -> None:
    """Write the commands of the four motors [PWM]."""
    r = frame[SHARE_TILT] * truncate(0.5 * memory[CONTROL], INT32_MAX)
    p = frame[SHARE_TILT] * truncate(0.5 * memory[CONTROL + 1], INT32_MAX)
    y, thrust = frame[SHARE_YAW] * memory[CONTROL + 2], memory[CONTROL + 3]
    memory[MOTOR_COMMAND] = truncate(thrust - r + p + y, INT32_MAX)
    memory[MOTOR_COMMAND + 1] = truncate(thrust - r - p - y, INT32_MAX)
    memory[MOTOR_COMMAND + 2] = truncate(thrust + r - p + y, INT32_MAX)
    memory[MOTOR_COMMAND + 3] = truncate(thrust + r + p - y, INT32_MAX)


@compiled
def cap(duties: Array, idle: float) -> None:
    """Lower the duties (4,) equally until none is above 65535, then raise each to `idle` at least."""
    excess = max(max(duties[0], duties[1], duties[2], duties[3]) - PWM_TOP, 0.0)
    for k in range(4):
        duties[k] = max(duties[k] - excess, idle)


@compiled
def drive_motors(setpoint: Array, memory: Array, frame: Array, forces: Array) -> None:
    """Write the four motors' duties into memory, and their commanded forces (4,) [N]."""
    duties = memory[MOTOR : MOTOR + 4]
    duties[:] = 0.0
    mix(memory, frame)
    if setpoint[MOTORS_ON] != 0.0:
        for k in range(4):
            duties[k] = truncate(compensate(memory[MOTOR_COMMAND + k], setpoint[SUPPLY]), INT32_MAX)
        cap(duties, setpoint[IDLE])
    for k in range(4):
        forces[k] = min(frame[NEWTON_PER_PWM] * thrust_pwm(duties[k], setpoint[BATTERY]), frame[ROTOR_MAX])
