"""The firmware's extended Kalman filter: linearisation, corrections, and the weaknesses that are kept."""

import numpy as np
import pytest

from q2q_model.geometry.rotations import (
    identity_quat,
    integrate_quat,
    matrix_from_quat,
    quat_from_euler,
    quat_from_vector,
    quat_multiply,
    rotate,
    rotate_inverse,
    vector_from_quat,
)
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import GRAVITY
from q2q_sim.firmware.estimator import DT, Estimator
from q2q_sim.firmware.extended_kalman import D, ExtendedKalman, ExtendedKalmanParams, P, X, kalman_transition

LEVEL = identity_quat((1,))
ALL = np.ones(1, dtype=np.bool_)
HOVER = np.array([[0.0, 0.0, GRAVITY]])
STILL = np.zeros((1, 3))


def test_the_covariance_moves_by_the_derivative_of_the_motion() -> None:
    """Central differences of x' = R p, p' = f - w x p - R^T g, in x, p and a turn of the attitude."""
    draw = np.random.default_rng(1)
    quat, p, w = quat_from_vector(0.4 * draw.standard_normal((1, 3))), draw.standard_normal((1, 3)), STILL

    def after(step: Array) -> Array:
        turned = quat_multiply(quat, quat_from_vector(step[None, D]))
        R, vel = matrix_from_quat(turned), p + step[P]
        pos = step[X] + DT * np.einsum("nij,nj->ni", R, vel)[0]
        moved = vel + DT * (HOVER - np.cross(w, vel) - GRAVITY * R[:, 2])
        return np.concatenate([pos, moved[0], step[D]])

    h = 1e-6
    columns = [(after(h * one) - after(-h * one)) / (2.0 * h) for one in np.eye(9)]
    np.testing.assert_allclose(
        kalman_transition(matrix_from_quat(quat), p, w)[0], np.stack(columns, axis=1), atol=1e-9
    )


def test_an_exact_imu_and_no_pose_carry_the_estimate_along_a_turning_fall() -> None:
    """Without drag the z of the accelerometer is all of the force; Euler's error is O(dt)."""
    quat, vel, pos = quat_from_euler(0.2, -0.1, 0.3)[None], np.zeros((1, 3)), np.zeros((1, 3))
    rate, thrust = np.array([[0.3, -0.2, 0.5]]), np.array([[0.0, 0.0, 11.0]])
    estimator = ExtendedKalman(ExtendedKalmanParams(), quat.copy())
    for _ in range(50):
        estimator.predict(thrust, rate, flying=True)
        acc = rotate(integrate_quat(quat, rate, 0.5 * DT), thrust) - [0.0, 0.0, GRAVITY]
        pos, vel = pos + DT * vel + 0.5 * DT**2 * acc, vel + DT * acc
        quat = integrate_quat(quat, rate, DT)
    np.testing.assert_allclose(estimator.quat, quat, atol=1e-12)
    np.testing.assert_allclose(estimator.pos, pos, atol=0.01)
    assert np.linalg.norm(pos) > 0.3


def test_poses_draw_position_and_attitude_to_themselves() -> None:
    place, turned = np.array([[1.0, -2.0, 0.5]]), quat_from_euler(0.0, 0.0, 0.1)[None]
    estimator = ExtendedKalman(ExtendedKalmanParams(), LEVEL)
    for _ in range(500):
        estimator.predict(HOVER, STILL, flying=True)
        estimator.correct(ALL, place, turned)
    np.testing.assert_allclose(estimator.pos, place, atol=1e-4)
    yaw = vector_from_quat(estimator.quat)[0]
    np.testing.assert_allclose(yaw, [0.0, 0.0, 0.1], atol=2e-3)  # small turns are dropped


def test_at_hover_it_is_the_filter_that_the_emulated_vehicles_fly_with() -> None:
    """Level, at rest and with a known attitude, x and p are decoupled from d: the two axes' filter."""
    certain = ExtendedKalmanParams(gyro_noise=0.0, quat_std=1e-6)
    estimator, drift = ExtendedKalman(certain, LEVEL), np.zeros(6)
    simple = Estimator(drift)
    for place in np.random.default_rng(2).normal(0.0, 0.02, (200, 3)):
        estimator.predict(HOVER, STILL, flying=True)
        estimator.correct(ALL, place[None], LEVEL)
        simple.predict(np.array([0.5, 0.5, 1.0]))
        drift[:3] += DT * drift[3:]
        simple.correct(place, np.zeros(3), 0.01)
    np.testing.assert_allclose(estimator.pos[0], drift[:3], atol=2e-3)
    np.testing.assert_allclose(np.diag(estimator.cov[0])[:6], simple.variance, rtol=0.1)


def test_a_vehicle_without_a_pose_is_left_alone() -> None:
    estimator = ExtendedKalman(ExtendedKalmanParams(), identity_quat((2,)))
    estimator.predict(np.tile(HOVER, (2, 1)), np.zeros((2, 3)), flying=True)
    before = estimator.cov.copy()
    place = np.full((2, 3), 0.3)
    estimator.correct(np.array([True, False]), place, identity_quat((2,)))
    np.testing.assert_allclose(estimator.pos, [[0.3] * 3, [0.0] * 3], atol=0.03)
    np.testing.assert_allclose(estimator.cov[1], before[1], rtol=1e-12)
    assert estimator.cov[0, 0, 0] < 1e-3 * before[0, 0, 0]


@pytest.mark.parametrize(("all_axes", "missed"), [(False, 0.4), (True, 0.0)])
def test_drag_is_missed_unless_all_axes_count(*, all_axes: bool, missed: float) -> None:
    """Level at constant acceleration by drag: 0.4 m/s^2 over a second are 0.2 m and 0.4 m/s."""
    estimator = ExtendedKalman(ExtendedKalmanParams(all_axes=all_axes), LEVEL)
    for _ in range(100):
        estimator.predict(HOVER + np.array([-0.4, 0.0, 0.0]), STILL, flying=True)
    np.testing.assert_allclose(estimator.vel_body[0, 0], missed - 0.4, atol=1e-9)


def test_an_estimate_that_leaves_all_bounds_starts_again() -> None:
    estimator = ExtendedKalman(ExtendedKalmanParams(), LEVEL)
    for _ in range(200):
        estimator.predict(HOVER + np.array([0.0, 0.0, 10.0]), STILL, flying=True)
    estimator.correct(np.zeros(1, dtype=np.bool_), STILL, LEVEL)
    assert estimator.resets.tolist() == [1]
    assert estimator.pos.tolist() == [[0.0, 0.0, 0.0]]
    assert rotate_inverse(estimator.quat, HOVER).tolist() == HOVER.tolist()
