"""Columns of the rows that the compiled controllers read and write, one row for each vehicle.

| row | width | content |
|---|---|---|
| setpoint | SETPOINT_WIDTH | Setpoint and Power |
| gains | GAIN_WIDTH | parameter_table.GAINS, then stabilizer.controller |
| memory | MEMORY_WIDTH | integrals, last measurements, outputs for logs |
| frame | FRAME_WIDTH | Airframe |
| drift | 6 | error of the estimator: position [m], velocity [m/s], world |
"""

from dataclasses import dataclass

import numpy as np

from q2q_model.signals.values import Array
from q2q_sim.firmware.commander.setpoint import Mode, Setpoint
from q2q_sim.firmware.motors.airframe import Airframe
from q2q_sim.firmware.motors.battery import VOLT_FULL
from q2q_sim.firmware.parameters.parameter_table import GAINS

DISABLE, ABS, VELOCITY = (float(mode) for mode in (Mode.DISABLE, Mode.ABS, Mode.VELOCITY))
"""Modes in the row of a setpoint."""
MODE_X, MODE_Y, MODE_Z, MODE_ROLL, MODE_PITCH, MODE_YAW, MODE_QUAT = range(7)
SET_POS, SET_VEL, SET_ACC, SET_ATTITUDE, SET_RATE, SET_QUAT = 7, 10, 13, 16, 19, 22
SET_THRUST, SET_BODY = 26, 27
MOTORS_ON, IDLE, SUPPLY, BATTERY = 28, 29, 30, 31
SETPOINT_WIDTH = 32

KP_XY, KD_XY, KI_XY, I_RANGE_XY, KP_Z, KD_Z, KI_Z, I_RANGE_Z, MASS, MASS_THRUST = (
    GAINS.index(f"ctrlMel.{name}")
    for name in (
        "kp_xy",
        "kd_xy",
        "ki_xy",
        "i_range_xy",
        "kp_z",
        "kd_z",
        "ki_z",
        "i_range_z",
        "mass",
        "massThrust",
    )
)
KR_XY, KR_Z, KW_XY, KW_Z, KI_M_XY, KI_M_Z, KD_OMEGA, I_RANGE_M_XY, I_RANGE_M_Z = (
    GAINS.index(f"ctrlMel.{name}")
    for name in (
        "kR_xy", "kR_z", "kw_xy", "kw_z", "ki_m_xy", "ki_m_z", "kd_omega_rp", "i_range_m_xy", "i_range_m_z",
    )
)  # fmt: skip
VEL_GAINS, POS_GAINS = GAINS.index("velCtlPid.vxKp"), GAINS.index("posCtlPid.xKp")
"""kp, ki, kd of x, then y, then z."""
VEL_FEED = GAINS.index("velCtlPid.vxKFF")
"""x, then y, then z."""
THRUST_BASE, THRUST_MIN = GAINS.index("posCtlPid.thrustBase"), GAINS.index("posCtlPid.thrustMin")
ROLL_LIMIT, PITCH_LIMIT = GAINS.index("posCtlPid.rLimit"), GAINS.index("posCtlPid.pLimit")
VEL_MAX = GAINS.index("posCtlPid.xVelMax")
"""x, then y, then z."""
ATTITUDE_GAINS, RATE_GAINS = GAINS.index("pid_attitude.roll_kp"), GAINS.index("pid_rate.roll_kp")
"""kp, ki, kd of roll, then pitch, then yaw."""
CONTROLLER = len(GAINS)
GAIN_WIDTH = CONTROLLER + 1

I_POS, I_MOMENT, LAST_RATE, LAST_SET_RATE, Z_AXIS_SETPOINT = 0, 3, 6, 8, 10
PIDS, PID_WIDTH = 13, 4
"""Twelve PIDs of 4 columns: integral, last measurement, two of its filter."""
PID_X, PID_VX, PID_ROLL, PID_ROLL_RATE = 0, 3, 6, 9
"""Number of the first PID of three axes."""
ATTITUDE_SETPOINT = PIDS + 12 * PID_WIDTH
THRUST_SETPOINT = ATTITUDE_SETPOINT + 3
LAST_MODES = THRUST_SETPOINT + 1
CONTROL = LAST_MODES + 7
"""Output: roll, legacy pitch, yaw, thrust [PWM]."""
MOTOR_COMMAND = CONTROL + 4
"""Commands of the four motors [PWM]."""
MOTOR = MOTOR_COMMAND + 4
"""Duty of the four motors; 65535 is 100 %."""
RATE_SETPOINT = MOTOR + 4
POS_TARGET, VEL_TARGET = RATE_SETPOINT + 3, RATE_SETPOINT + 6
"""Setpoints of the position PIDs, in the frame rotated by the yaw [m], [m/s]."""
MEMORY_WIDTH = VEL_TARGET + 3

NEWTON_PER_PWM, SHARE_TILT, SHARE_YAW, ROTOR_MAX = range(4)
FRAME_WIDTH = 4


@dataclass(frozen=True, slots=True)
class Power:
    """Limits of the motors and their supply."""

    motors_on: bool = True
    idle_pwm: float = 0.0
    """Smallest duty of a running motor [PWM]."""
    supply: float = VOLT_FULL
    """Supply voltage as the firmware measures it [V]."""
    battery: float = VOLT_FULL
    """True voltage [V]."""


def setpoint_row(setpoint: Setpoint, power: Power) -> Array:
    """Return the row of a setpoint, (SETPOINT_WIDTH,)."""
    one = setpoint
    modes = (one.x, one.y, one.z, one.roll, one.pitch, one.yaw, one.quat)
    numbers = (*one.pos, *one.vel, *one.acc, *one.attitude_deg, *one.rate_deg, *one.attitude_quat)
    feed = (power.motors_on, power.idle_pwm, power.supply, power.battery)
    return np.array([*modes, *numbers, one.thrust_pwm, one.velocity_body, *feed], dtype=np.float64)


def frame_row(airframe: Airframe) -> Array:
    """Return the row of an airframe, (FRAME_WIDTH,)."""
    one = airframe
    return np.array([one.newton_per_pwm, one.share_tilt, one.share_yaw, one.rotor_max])


def fresh_memory(vehicles: int) -> Array:
    """Return the initial memory of the controllers, (vehicles, MEMORY_WIDTH)."""
    return np.zeros((vehicles, MEMORY_WIDTH))
