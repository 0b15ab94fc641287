"""Motors of the emulated firmware: thrust of a setpoint, duties by the battery, idle thrust."""

import numpy as np
import pytest
from firmware_rows import parameters, row_at, torque_for

from q2q_model.vehicle.constants import CRAZYFLIE_2_0
from q2q_sim.firmware.commander.setpoint import Mode, Setpoint
from q2q_sim.firmware.controllers.columns import (
    CONTROL,
    MEMORY_WIDTH,
    MOTOR,
    NEWTON_PER_PWM,
    Power,
    frame_row,
    setpoint_row,
)
from q2q_sim.firmware.controllers.mixer import drive_motors
from q2q_sim.firmware.motors.airframe import airframe_of
from q2q_sim.firmware.motors.thrust_curve import compensate, thrust_pwm


def test_thrust_is_that_of_the_setpoint_and_motors_never_leave_their_range() -> None:
    gains = parameters()
    hover = Setpoint(roll=Mode.ABS, pitch=Mode.ABS, yaw=Mode.VELOCITY, thrust_pwm=30000.0)
    thrust, *_ = torque_for(hover, row_at(), gains)
    assert thrust == pytest.approx(30000.0 / 65535.0 * 0.48, rel=1e-4)  # a duty is a whole number of 65535ths
    memory, forces = np.zeros(MEMORY_WIDTH), np.zeros(4)
    memory[CONTROL : CONTROL + 4] = 30000.0, -30000.0, 30000.0, 30000.0  # asks for 30000, 0, 90000, 0
    drive_motors(
        setpoint_row(hover, Power(supply=3.0)), memory, frame_row(airframe_of(CRAZYFLIE_2_0)), forces
    )
    assert memory[MOTOR : MOTOR + 4].max() == 65535.0
    assert memory[MOTOR : MOTOR + 4].min() == 0.0
    drive_motors(
        setpoint_row(hover, Power(motors_on=False)), memory, frame_row(airframe_of(CRAZYFLIE_2_0)), forces
    )
    np.testing.assert_array_equal(forces, 0.0)


@pytest.mark.parametrize(
    ("asked", "supply", "duty"),
    [(6999.0, 4.2, 0.0), (7000.0, 4.2, 12075.9688), (36000.0, 4.2, 35861.8281), (36000.0, 3.4, 44299.9023)],
)
def test_duty_makes_up_for_the_battery_and_a_motor_below_7000_pwm_stands_still(
    asked: float, supply: float, duty: float
) -> None:
    """The firmware's own numbers, and back: the curve gives at that duty what was asked for."""
    assert compensate(asked, supply) == pytest.approx(duty, rel=1e-6)  # theirs has 32 bits
    given = thrust_pwm(compensate(asked, supply), supply)
    assert given == pytest.approx(asked if duty else 0.0, rel=1e-9)


def test_duties_are_lowered_alike_after_compensation_and_lifted_to_the_idle_thrust() -> None:
    memory, forces = np.zeros(MEMORY_WIDTH), np.zeros(4)
    memory[CONTROL : CONTROL + 4] = 0.0, 60000.0, 0.0, 35535.0  # asks for 65535, 5535, 5535, 65535
    low = Power(supply=3.0, battery=3.0, idle_pwm=300.0)
    frame = frame_row(airframe_of(CRAZYFLIE_2_0))
    drive_motors(setpoint_row(Setpoint(), low), memory, frame, forces)
    np.testing.assert_array_equal(memory[MOTOR : MOTOR + 4], [65535.0, 300.0, 300.0, 65535.0])
    full = compensate(65535.0, 3.0)
    assert full == pytest.approx(
        67280.7266, rel=1e-6
    )  # 32 bits; more than there is: less than asked is given
    assert forces[0] / frame[NEWTON_PER_PWM] == pytest.approx(thrust_pwm(65535.0, 3.0))
    assert forces[0] / frame[NEWTON_PER_PWM] < 65535.0
    np.testing.assert_array_equal(forces[1:3], 0.0)
    drive_motors(setpoint_row(Setpoint(), Power()), memory, frame, forces)
    assert memory[MOTOR] < 65535.0
    memory[CONTROL + 3] = (
        60000.0  # asks for 90000, 30000, 30000, 90000: a full battery could, its load would not
    )
    drive_motors(setpoint_row(Setpoint(), Power()), memory, frame, forces)
    assert forces.max() == pytest.approx(CRAZYFLIE_2_0.thrust_max / 4)
