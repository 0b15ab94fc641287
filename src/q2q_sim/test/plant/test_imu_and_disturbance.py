"""Tests of what inertial sensors read, and how the air and the rotors disturb."""

import numpy as np
import pytest
from resting_signals import resting_state

from q2q_model.geometry.rotations import quat_from_euler
from q2q_model.signals.values import SwarmState
from q2q_sim.plant.disturbance import Disturbance, DisturbanceParams
from q2q_sim.sensors.imu import Imu, ImuParams


def _tilted(roll: float, pitch: float) -> SwarmState:
    return resting_state(
        0.0,
        ("cf1",),
        np.zeros((1, 3)),
        quat=quat_from_euler(np.array([roll]), np.array([pitch]), np.array([0.4])),
        ang_vel_body=np.array([[0.1, 0.2, 0.3]]),
    )


def test_a_resting_sensor_reads_the_weight_along_its_own_up() -> None:
    reading = Imu(ImuParams(), 1, 0).read(_tilted(0.3, 0.0), np.zeros((1, 3)))
    np.testing.assert_allclose(
        reading.specific_force_body, [[0, 9.81 * np.sin(0.3), 9.81 * np.cos(0.3)]], atol=1e-12
    )
    np.testing.assert_array_equal(reading.ang_vel_body, [[0.1, 0.2, 0.3]])


def test_a_falling_sensor_reads_nothing() -> None:
    reading = Imu(ImuParams(), 1, 0).read(_tilted(0.3, -0.2), np.array([[0.0, 0.0, -9.81]]))
    np.testing.assert_allclose(reading.specific_force_body, 0.0, atol=1e-12)


def test_biases_stay_and_noise_changes() -> None:
    imu = Imu(ImuParams(acc_noise=0.02, acc_bias=0.05), 1, 5)
    readings = np.array(
        [imu.read(_tilted(0, 0), np.zeros((1, 3))).specific_force_body[0] for _ in range(4000)]
    )
    assert readings.std(axis=0) == pytest.approx(0.02, rel=4.0 / np.sqrt(2 * 4000))
    again = Imu(ImuParams(acc_bias=0.05), 1, 5).read(_tilted(0, 0), np.zeros((1, 3))).specific_force_body[0]
    np.testing.assert_allclose(readings.mean(axis=0), again, atol=4.0 * 0.02 / np.sqrt(4000))
    assert np.abs(again - [0.0, 0.0, 9.81]).max() > 0.005


def test_the_air_wanders_with_its_deviation_and_its_memory() -> None:
    n, ticks, tau, std = 200, 2000, 0.5, 0.3
    air = Disturbance(DisturbanceParams(air_std=std, air_time=tau), n, 0.01, 2)
    pushes = np.array([air.step()[:, :3] for _ in range(ticks)])  # (T, n, 3)
    independent = 3 * n * ticks * 0.01 / (2.0 * tau)
    assert pushes.std() == pytest.approx(std, rel=4.0 / np.sqrt(2.0 * independent))
    assert pushes[0].std() == pytest.approx(std, rel=4.0 / np.sqrt(2.0 * 3 * n))  # stationary at once
    late = 50
    memory = np.mean(pushes[:-late] * pushes[late:]) / np.mean(pushes**2)
    assert memory == pytest.approx(np.exp(-late * 0.01 / tau), abs=4.0 / np.sqrt(independent))


def test_rotor_gains_are_drawn_once_a_flight_within_their_bounds() -> None:
    quiet = Disturbance(DisturbanceParams(thrust_gain_min=0.97, thrust_gain_max=0.99), 50, 0.01, 3)
    first, second = quiet.step(), quiet.step()
    np.testing.assert_array_equal(first, second)
    assert first[:, 3:].min() >= 0.97
    assert first[:, 3:].max() <= 0.99
    assert np.ptp(first[:, 3]) > 0.01
    np.testing.assert_array_equal(first[:, 3], first[:, 6])
    np.testing.assert_array_equal(first[:, :3], 0.0)


def test_bounds_the_wrong_way_round_are_refused() -> None:
    with pytest.raises(ValueError, match=r"thrust_gain_min = 1.0 is above thrust_gain_max = 0.9"):
        DisturbanceParams(thrust_gain_max=0.9)
