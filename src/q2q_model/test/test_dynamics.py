"""Tests of (1)-(9) against a rigid body without Euler angles."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from q2q_model.vehicle.constants import CRAZYFLIE_2_0, GRAVITY, TEXTBOOK_065, Vehicle
from q2q_model.vehicle.dynamics import angular_acceleration, linear_acceleration, thrust_direction

angle = st.floats(-3.0, 3.0)
ROUNDING = 1e-12  # a few operations on numbers near 1


@given(angle, angle, angle)
def test_thrust_direction_is_the_body_z_axis_of_the_rotation_matrix(roll: float, pitch: float, yaw: float):
    body_z = Rotation.from_euler("ZYX", [yaw, pitch, roll]).apply([0.0, 0.0, 1.0])
    np.testing.assert_allclose(thrust_direction(np.array([roll, pitch, yaw])), body_z, atol=ROUNDING)


@pytest.mark.parametrize("vehicle", [CRAZYFLIE_2_0, TEXTBOOK_065])
def test_angular_acceleration_solves_eulers_rigid_body_equation(vehicle: Vehicle):
    rng = np.random.default_rng(1)
    rates, moments = rng.normal(size=(20, 3)), 1e-3 * rng.normal(size=(20, 3))
    spin = rng.normal(size=20) * 100.0
    inertia = np.array(vehicle.inertia)
    torque = moments * np.array([vehicle.arm, vehicle.arm, 1.0])  # U4 is a torque already
    acc = angular_acceleration(rates, moments, vehicle, spin)
    rotor = spin[:, None] * np.array(
        [0.0, 0.0, -vehicle.rotor_inertia]
    )  # a2 > 0 for rotors spinning downwards
    balance = inertia * acc + np.cross(rates, inertia * rates + rotor) - torque
    np.testing.assert_allclose(balance, 0.0, atol=1e-12 * np.abs(inertia * acc).max())


def test_rates_of_the_angles_differ_from_body_rates_by_tilt_times_rate():
    """Theta' = q cos(phi) - r sin(phi), so the error of taking q for theta' is r phi to first order."""

    def error(tilt: float) -> float:
        rates, step = np.array([0.3, -0.2, 0.1]), 1e-6
        start = Rotation.from_euler("ZYX", [0.0, tilt, tilt])
        moved = (start * Rotation.from_rotvec(step * rates)).as_euler("ZYX")[::-1]
        return float(np.abs((moved - np.array([tilt, tilt, 0.0])) / step - rates)[1])

    assert error(0.02) == pytest.approx(0.1 * 0.02, rel=0.05)  # next order: q phi^2 / 2, 2 % of it


def test_a_level_vehicle_with_its_weight_as_thrust_hovers_and_a_downwash_adds_to_it():
    hover = linear_acceleration(np.zeros(3), np.array(CRAZYFLIE_2_0.hover_thrust), CRAZYFLIE_2_0.mass)
    np.testing.assert_allclose(hover, 0.0, atol=ROUNDING)
    eta = np.array([0.1, -0.2, -0.3])
    pushed = linear_acceleration(np.zeros(3), np.array(0.0), CRAZYFLIE_2_0.mass, eta)
    np.testing.assert_allclose(pushed, eta - np.array([0.0, 0.0, GRAVITY]), atol=ROUNDING)


def test_pitching_up_flies_along_x_and_rolling_flies_to_the_right():
    nose_down, roll_right = np.array([0.0, 0.2, 0.0]), np.array([0.2, 0.0, 0.0])
    assert linear_acceleration(nose_down, np.array(1.0), 0.1)[0] > 1.0
    assert linear_acceleration(roll_right, np.array(1.0), 0.1)[1] < -1.0


def test_a_batch_is_the_same_as_a_loop():
    rng = np.random.default_rng(2)
    attitude, thrust, rates = rng.normal(size=(4, 5, 3)), rng.random((4, 5)), rng.normal(size=(4, 5, 3))
    batch = linear_acceleration(attitude, thrust, 0.03)
    turn = angular_acceleration(rates, rates, CRAZYFLIE_2_0)
    for k in np.ndindex(4, 5):
        np.testing.assert_array_equal(batch[k], linear_acceleration(attitude[k], thrust[k], 0.03))
        np.testing.assert_array_equal(turn[k], angular_acceleration(rates[k], rates[k], CRAZYFLIE_2_0))
