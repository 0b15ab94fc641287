"""Mix thrust and moments into motor PWM, and PWM into forces, in compiled code.

Source: firmware: modules/src/power_distribution_quadrotor.c (legacy mode), motors counted as in
q2q_control.allocation:

    m1 = T - r/2 + p/2 + y,  m2 = T - r/2 - p/2 - y,  m3 = T + r/2 - p/2 + y,  m4 = T + r/2 + p/2 - y

Is one above 65535, all are lowered alike; none is below 0. Shares of the airframe scale r, p and y.
"""

from numba import njit

from q2q_model.signals import Array
from q2q_sim.onboard.columns import CONTROL, MOTOR, MOTORS_ON, NEWTON_PER_PWM, SHARE_TILT, SHARE_YAW

PWM_TOP = 65535.0


def _mix(memory: Array, frame: Array) -> None:
    """Write the motors' PWM into memory."""
    r, p = 0.5 * frame[SHARE_TILT] * memory[CONTROL], 0.5 * frame[SHARE_TILT] * memory[CONTROL + 1]
    y, thrust = frame[SHARE_YAW] * memory[CONTROL + 2], memory[CONTROL + 3]
    m = MOTOR
    memory[m], memory[m + 1] = thrust - r + p + y, thrust - r - p - y
    memory[m + 2], memory[m + 3] = thrust + r - p + y, thrust + r + p - y
    excess = max(memory[m], memory[m + 1], memory[m + 2], memory[m + 3]) - PWM_TOP
    for k in range(4):
        pwm = memory[m + k] - max(excess, 0.0)
        memory[m + k] = min(pwm, PWM_TOP) if pwm > 0.0 else 0.0  # 0 for what senseless gains make no number


def _drive_motors(wanted: Array, memory: Array, frame: Array, forces: Array) -> None:
    """Write the forces [N] that the motors are asked for."""
    if wanted[MOTORS_ON] == 0.0:
        memory[MOTOR : MOTOR + 4] = 0.0
    else:
        mix(memory, frame)
    for k in range(4):
        forces[k] = frame[NEWTON_PER_PWM] * memory[MOTOR + k]


mix = njit(cache=True)(_mix)
drive_motors = njit(cache=True)(_drive_motors)
