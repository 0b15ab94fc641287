"""What closed loops of the emulated controllers do: settle, tilt, take a push out."""

import numpy as np
import pytest
from firmware_rows import MELLINGER, PID, STILL, parameters

from q2q_model.geometry.rotations import euler_from_quat
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, TEXTBOOK_065, Vehicle
from q2q_sim.air.wake_laws import WakeLaw
from q2q_sim.firmware.commander.setpoint import Mode, Setpoint
from q2q_sim.firmware.controllers.columns import (
    Power,
    frame_row,
    fresh_memory,
    setpoint_row,
)
from q2q_sim.firmware.controllers.state_attitude import legacy_degrees
from q2q_sim.firmware.firmware_tick import Controllers, fly_tick
from q2q_sim.firmware.motors.airframe import airframe_of
from q2q_sim.plant.body.state_row import QUAT
from q2q_sim.plant.swarm import Swarm


def flown(
    vehicle: Vehicle,
    controller: int,
    setpoint: Setpoint,
    seconds: float,
    drive: Array = STILL,
    **values: float,
) -> Swarm:
    swarm = Swarm(("cf1",), vehicle, np.array([[0.0, 0.0, 1.0, 0.0]]), WakeLaw.NONE)
    gains = parameters(vehicle, stabilizer__controller=controller, **values).gains()[None]
    rows = Controllers(
        np.tile(setpoint_row(setpoint, Power()), (1, 2, 1)), gains, fresh_memory(1),
        frame_row(airframe_of(vehicle))[None], np.zeros((1, 6)),
    )  # fmt: skip
    for _ in range(round(100 * seconds)):
        fly_tick(swarm, rows, drive)
    return swarm


@pytest.mark.parametrize("vehicle", [CRAZYFLIE_2_0, TEXTBOOK_065])
@pytest.mark.parametrize("controller", [PID, MELLINGER])
def test_both_controllers_settle_at_a_position_and_a_yaw_on_both_airframes(
    vehicle: Vehicle, controller: int
) -> None:
    there = Setpoint(
        x=Mode.ABS, y=Mode.ABS, z=Mode.ABS, yaw=Mode.ABS, pos=(0.5, -0.4, 1.3), attitude_deg=(0.0, 0.0, 70.0)
    )
    swarm = flown(vehicle, controller, there, 20.0)
    # integrals of 0.05 N/(m s) leave centimetres after 20 s
    np.testing.assert_allclose(swarm.state[0, :3], there.pos, atol=0.03)
    np.testing.assert_allclose(swarm.state[0, 3:6], 0.0, atol=0.01)
    assert legacy_degrees(swarm.state[0])[2] == pytest.approx(70.0, abs=1.0)


@pytest.mark.parametrize("controller", [PID, MELLINGER])
def test_a_wanted_tilt_is_reached_with_the_signs_of_the_house(controller: int) -> None:
    tilted = Setpoint(
        roll=Mode.ABS, pitch=Mode.ABS, yaw=Mode.VELOCITY, attitude_deg=(4.0, -6.0, 0.0), thrust_pwm=46000.0
    )
    swarm = flown(CRAZYFLIE_2_0, controller, tilted, 1.5)
    roll, pitch, _ = np.degrees(euler_from_quat(swarm.state[0, QUAT]))
    assert (roll, pitch) == (pytest.approx(4.0, abs=0.5), pytest.approx(6.0, abs=0.5))
    assert swarm.state[0, 3] > 0.5  # nose down flies forward
    assert swarm.state[0, 4] < -0.3  # right side down flies to the right


@pytest.mark.parametrize("vehicle", [CRAZYFLIE_2_0, TEXTBOOK_065])
def test_acceleration_of_the_setpoint_takes_a_constant_push_out_under_mellinger_only(
    vehicle: Vehicle,
) -> None:
    push = 0.5  # [m/s^2], downwards, as downwash
    exact = 65535.0 / vehicle.full_pwm_thrust  # [1/N]: the stock value is 3 % less
    drive = STILL + np.array([0.0, 0.0, -push, 0.0, 0.0, 0.0, 0.0])
    error = {}
    for controller in (PID, MELLINGER):
        for aware in (False, True):
            here = Setpoint(
                x=Mode.ABS, y=Mode.ABS, z=Mode.ABS, yaw=Mode.ABS, pos=(0.0, 0.0, 1.0),
                acc=(0.0, 0.0, push if aware else 0.0),
            )  # fmt: skip
            swarm = flown(vehicle, controller, here, 1.0, drive, ctrlMel__massThrust=exact)
            error[controller, aware] = 1.0 - swarm.state[0, 2]
    stiffness = parameters(vehicle)["ctrlMel.kp_z"] / vehicle.mass  # [1/s^2]
    # 1 s is 6 time constants of the loop less a little integral action
    assert error[MELLINGER, False] == pytest.approx(push / stiffness, rel=0.15)
    assert abs(error[MELLINGER, True]) < 0.15 * error[MELLINGER, False]  # the rotors' lag at the start
    assert error[PID, True] == error[PID, False]
