"""Tests of quaternions and Euler angles against their definitions, for every batch shape."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from q2q_model.geometry import rotations as rot
from q2q_model.geometry.yaw import yaw_of
from q2q_model.signals.values import Array

ROUNDING = 1e-12  # a few dozen products of numbers near 1 in float64


def _quats(rng: np.random.Generator, shape: tuple[int, ...]) -> Array:
    return rot.normalised(rng.standard_normal((*shape, 4)))


def _rx(a: float) -> Array:
    return np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])


def _ry(a: float) -> Array:
    return np.array([[np.cos(a), 0, np.sin(a)], [0, 1, 0], [-np.sin(a), 0, np.cos(a)]])


def _rz(a: float) -> Array:
    return np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])


shapes = st.sampled_from([(), (1,), (3,), (2, 3), (0,)])
seeds = st.integers(0, 2**32 - 1)
angles = st.floats(-3.1, 3.1)
pitches = st.floats(-1.5, 1.5)


@given(angles, pitches, angles)
def test_euler_angles_mean_yaw_after_pitch_after_roll(roll: float, pitch: float, yaw: float):
    quat = rot.quat_from_euler(roll, pitch, yaw)
    assert np.allclose(rot.matrix_from_quat(quat), _rz(yaw) @ _ry(pitch) @ _rx(roll), atol=ROUNDING)


@given(angles, pitches, angles)
def test_euler_angles_survive_the_round_trip(roll: float, pitch: float, yaw: float):
    back = rot.euler_from_quat(rot.quat_from_euler(roll, pitch, yaw))
    # near pitch 1.5 the angles amplify rounding by 1 / cos(1.5)^2 = 200
    assert np.allclose(back, [roll, pitch, yaw], atol=1e-9)


@pytest.mark.parametrize("pitch", [0.5 * np.pi, -0.5 * np.pi, 0.5 * np.pi - 1e-9])
@given(angles, angles)
def test_straight_up_and_down_euler_angles_are_of_the_same_attitude(pitch: float, roll: float, yaw: float):
    quat = rot.quat_from_euler(roll, pitch, yaw)
    again = rot.quat_from_euler(*rot.euler_from_quat(quat))
    assert np.allclose(rot.matrix_from_quat(again), rot.matrix_from_quat(quat), atol=ROUNDING)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(
    ("quat", "euler"),
    [
        ([0.0, 0.0, 1.0, 0.0], [0.0, 0.0, np.pi]),
        ([1.0, 0.0, 0.0, 0.0], [np.pi, 0.0, 0.0]),
        ([0.0, 1.0, 0.0, 0.0], [np.pi, 0.0, np.pi]),
        ([0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0]),
    ],
)
def test_half_turns_are_positive_and_no_attitude_is_level(quat: list[float], euler: list[float], sign: float):
    found = rot.euler_from_quat(sign * np.array(quat))
    assert found.tolist() == euler
    assert found[2] == rot.yaw_from_quat(sign * np.array(quat))


def test_tiny_euler_angles_keep_their_digits():
    euler = np.array([1e-12, 2e-12, 3e-12])
    np.testing.assert_allclose(
        rot.euler_from_quat(rot.quat_from_euler(*euler)), euler, rtol=ROUNDING, atol=0.0
    )


@given(seeds)
def test_the_yaw_of_one_quaternion_is_that_of_many(seed: int):
    quat = _quats(np.random.default_rng(seed), ())
    assert abs(yaw_of(*quat.tolist()) - rot.yaw_from_quat(quat)) <= ROUNDING


def test_positive_pitch_tips_thrust_along_plus_x_and_positive_roll_along_minus_y():
    up = np.array([0.0, 0.0, 1.0])
    assert np.allclose(rot.rotate(rot.quat_from_euler(0, 0.1, 0), up), [np.sin(0.1), 0, np.cos(0.1)])
    assert np.allclose(rot.rotate(rot.quat_from_euler(0.1, 0, 0), up), [0, -np.sin(0.1), np.cos(0.1)])


@given(seeds, shapes)
def test_rotating_equals_multiplying_by_the_matrix_and_back(seed: int, shape: tuple[int, ...]):
    rng = np.random.default_rng(seed)
    quat, vector = _quats(rng, shape), rng.standard_normal((*shape, 3))
    turned = rot.rotate(quat, vector)
    assert turned.shape == (*shape, 3)
    by_matrix = (rot.matrix_from_quat(quat) @ vector[..., None])[..., 0]
    assert np.allclose(turned, by_matrix, atol=ROUNDING)
    assert np.allclose(rot.rotate_inverse(quat, turned), vector, atol=ROUNDING)


@given(seeds, shapes)
def test_a_product_of_quaternions_is_the_product_of_their_matrices(seed: int, shape: tuple[int, ...]):
    rng = np.random.default_rng(seed)
    left, right = _quats(rng, shape), _quats(rng, shape)
    product = rot.matrix_from_quat(rot.quat_multiply(left, right))
    assert np.allclose(product, rot.matrix_from_quat(left) @ rot.matrix_from_quat(right), atol=ROUNDING)


@given(seeds, shapes, st.floats(1e-3, 0.1))
def test_body_rate_survives_integration(seed: int, shape: tuple[int, ...], dt: float):
    rng = np.random.default_rng(seed)
    quat, rate = _quats(rng, shape), rng.standard_normal((*shape, 3)) * 5.0
    after = rot.integrate_quat(quat, rate, dt)
    # the rate is a difference of unit quaternions over dt: rounding 1e-16 / 1e-3
    assert np.allclose(rot.ang_vel_between(quat, after, dt), rate, atol=1e-11)
    assert np.allclose(rot.ang_vel_between(quat, -after, dt), rate, atol=1e-11)


@given(seeds)
def test_the_derivative_is_the_limit_of_integration(seed: int):
    rng = np.random.default_rng(seed)
    quat, rate, dt = _quats(rng, (4,)), rng.standard_normal((4, 3)), 1e-6
    central = (rot.integrate_quat(quat, rate, dt) - rot.integrate_quat(quat, rate, -dt)) / (2 * dt)
    derivative = 0.5 * rot.quat_multiply(quat, np.concatenate([rate, np.zeros((4, 1))], axis=1))
    # rounding of a central difference: 1e-16 / 1e-6
    assert np.allclose(derivative, central, atol=1e-9)


def test_a_zero_quaternion_is_no_attitude():
    assert np.isnan(rot.normalised(np.zeros(4))).all()


def test_continuous_quaternions_turn_alike_and_do_not_jump() -> None:
    turn = np.linspace(0.0, 4.0 * np.pi, 50)
    quat = rot.quat_from_euler(0.0 * turn, 0.0 * turn, turn)
    quat[7::3] *= -1.0
    found = rot.continuous_quats(quat)
    assert (found[0] == quat[0]).all()
    assert np.abs(np.diff(found, axis=0)).max() < 0.13  # half the turn from row to row
    np.testing.assert_array_equal(np.abs(found), np.abs(quat))
    assert rot.continuous_quats(np.empty((0, 4))).shape == (0, 4)


def test_a_tiny_turn_has_no_division_by_zero():
    assert np.allclose(rot.quat_from_vector(np.zeros(3)), [0, 0, 0, 1])
    tiny = np.array([1e-12, 0, 0])
    assert np.allclose(rot.vector_from_quat(rot.quat_from_vector(tiny)), tiny, atol=0, rtol=1e-12)
