"""Prove the gates of the compiled tick with absent vehicles, each on both sides of its bound."""

import math

import numpy as np
import pytest

from q2q_model.estimation import white_jerk
from q2q_model.estimation.partial_frame import WIDTH, follow_present, turn_present
from q2q_model.geometry.rotations import identity_quat, quat_from_euler
from q2q_model.signals.values import Array

NOISE_VAR, DENSITY, COAST, JUMP, SPEED, SIGMAS, ROOM, ROUNDING = 1e-6, 64.0, 0.35, 0.05, 5.0, 1.0, 10.0, 1e-9
NUMBERS = np.array([NOISE_VAR, DENSITY, COAST, JUMP, SPEED, SIGMAS, ROOM, ROUNDING])
TURNING = (0.35, 12.0, 0.02, COAST)
SINCE = np.array([0.01, 0.05])
NEAR = 1e-6
"""On this side or that of a bound [m], [rad]."""


def tracks(since: Array = SINCE) -> tuple[Array, Array, Array]:
    rng = np.random.default_rng(3)
    state = rng.normal(size=(2, 3, 3))
    cov = np.tile(np.diag([1e-6, 1e-3, 1.0]), (2, 1, 1))
    return since.copy(), state, cov


def expected(made: tuple[Array, Array, Array]) -> tuple[Array, Array]:
    since, state, cov = made
    moved, spread = white_jerk.transition(np.minimum(since, COAST), DENSITY)
    return moved @ state, moved @ cov @ moved.transpose(0, 2, 1) + spread


def follow(measured: Array, made: tuple[Array, Array, Array]) -> tuple[bool, Array]:
    out = np.full((2, 6), np.nan)
    return follow_present(measured, made, NUMBERS, np.empty((2, WIDTH)), out), out


def test_present_ones_are_corrected_and_absent_ones_expected_by_the_equations_of_white_jerk():
    made = tracks()
    ahead, cov = expected(made)
    before = made[1][1].copy(), made[2][1].copy()
    measured = np.array([ahead[0, 0] + 0.01, [np.nan] * 3])
    better, spread = white_jerk.correct(ahead, cov, measured, NOISE_VAR)
    taken, out = follow(measured, made)
    assert taken
    np.testing.assert_allclose(made[1][0], better[0], rtol=1e-12, atol=1e-12)  # sums in another order
    np.testing.assert_allclose(made[2][0], spread[0], rtol=1e-9, atol=1e-15)  # differences of near numbers
    assert np.array_equal(made[1][1], before[0])
    assert np.array_equal(made[2][1], before[1])
    np.testing.assert_allclose(out[0], [*better[0, 0], *better[0, 1]], rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(out[1], [*ahead[1, 0], *ahead[1, 1]], rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize(("beyond", "fits"), [(-NEAR, True), (NEAR, False)])
@pytest.mark.parametrize("axis", range(3))
def test_a_sample_beyond_the_gate_on_position_leaves_all_untouched(axis: int, beyond: float, *, fits: bool):
    made = tracks()
    kept = tuple(part.copy() for part in made)
    ahead, cov = expected(made)
    gate = JUMP + SIGMAS * math.sqrt(cov[1, 0, 0] + NOISE_VAR)
    measured = ahead[:, 0].copy()
    measured[1, axis] += gate + beyond
    assert follow(measured, made)[0] == fits
    if not fits:
        assert all(np.array_equal(one, other) for one, other in zip(made, kept, strict=True))


@pytest.mark.parametrize(("beyond", "fits"), [(-NEAR, True), (NEAR, False)])
def test_a_sample_beyond_the_reach_of_a_vehicle_is_not_taken(beyond: float, *, fits: bool):
    made = tracks()
    reach = JUMP + SPEED * SINCE[0]
    made[1][0, 1], made[1][0, 2] = [(reach - 0.04) / SINCE[0], 0.0, 0.0], 0.0  # the gate is wider there
    measured = np.array([made[1][0, 0] + [reach + beyond, 0.0, 0.0], [np.nan] * 3])
    assert follow(measured, made)[0] == fits


@pytest.mark.parametrize(("beyond", "fits"), [(-NEAR, True), (NEAR, False)])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_sample_beyond_the_room_is_not_taken(side: float, beyond: float, *, fits: bool):
    made = tracks()
    made[1][0] = 0.0
    made[1][0, 0, 2] = side * (ROOM - 0.01)
    measured = np.array([[0.0, 0.0, side * (ROOM + beyond)], [np.nan] * 3])
    assert follow(measured, made)[0] == fits


@pytest.mark.parametrize(("beyond", "fits"), [(0.0, True), (1e-6, False)])
@pytest.mark.parametrize("present", [True, False])
def test_a_vehicle_that_has_coasted_is_for_the_general_road(beyond: float, *, fits: bool, present: bool):
    made = tracks(np.array([0.01, COAST + beyond]))
    ahead, _ = expected(made)
    measured = ahead[:, 0].copy()
    if not present:
        measured[1] = np.nan
    assert follow(measured, made)[0] == fits


def turned(yaw: float, since: float = 0.01) -> tuple[bool, Array, Array]:
    """Return whether a turn of the first vehicle by `yaw` [rad] is taken; the second one is absent."""
    quat, rate = identity_quat((2,)), np.ones((2, 3))
    pose = np.full((2, 7), np.nan)
    pose[0, 3:] = quat_from_euler(0.0, 0.0, yaw)
    return turn_present(pose, (quat, rate), np.array([since, 0.02]), TURNING), quat, rate


def test_a_turn_is_taken_and_the_rate_of_an_absent_vehicle_is_zero():
    taken, quat, rate = turned(0.02)
    assert taken
    np.testing.assert_allclose(quat[0], quat_from_euler(0.0, 0.0, 0.02), atol=1e-15)
    blend = 0.01 / (0.01 + 0.02)
    np.testing.assert_allclose(rate[0], [1.0 - blend, 1.0 - blend, 1.0 + blend * (2.0 - 1.0)], atol=1e-12)
    np.testing.assert_array_equal(rate[1], 0.0)
    np.testing.assert_array_equal(quat[1], [0.0, 0.0, 0.0, 1.0])


@pytest.mark.parametrize("since", [0.01, 0.1])
@pytest.mark.parametrize(("beyond", "fits"), [(-NEAR, True), (NEAR, False)])
def test_a_turn_beyond_belief_leaves_all_untouched(since: float, beyond: float, *, fits: bool):
    taken, quat, rate = turned(0.35 + 12.0 * since + beyond, since)
    assert taken == fits
    if not fits:
        np.testing.assert_array_equal(quat, identity_quat((2,)))
        np.testing.assert_array_equal(rate, 1.0)


def test_a_vehicle_found_again_after_coasting_is_for_the_general_road():
    assert turned(0.0, COAST)[0]
    assert not turned(0.0, COAST + 1e-6)[0]


@pytest.mark.parametrize("length", [0.94, 1.06])
def test_a_damaged_quaternion_is_for_the_general_road(length: float):
    pose = np.full((2, 7), np.nan)
    pose[0, 3:] = [0.0, 0.0, 0.0, length]
    assert not turn_present(pose, (identity_quat((2,)), np.zeros((2, 3))), SINCE, TURNING)
