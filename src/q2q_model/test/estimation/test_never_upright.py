"""The mocap filter on vehicles whose attitudes were upside down from the first one on."""

from dataclasses import replace

import numpy as np
import pytest
from mocap_frames import PAIR, TRACKED, frame_at, time_of, truth_at

from q2q_model.downwash.jet import MEASURED_LAW
from q2q_model.downwash.predictor import InteractionPredictor
from q2q_model.estimation.attitude.attitude_tracks import measured_attitudes
from q2q_model.estimation.mocap_filter import MocapFilter
from q2q_model.estimation.mocap_filter_params import MocapFilterParams
from q2q_model.geometry.rotations import identity_quat, quat_from_euler, quat_multiply


def test_a_first_attitude_upside_down_is_refused_and_the_first_upright_one_is_taken():
    block, tilted = MocapFilter(MocapFilterParams(), PAIR), np.tile(quat_from_euler(1.5, 0.0, 2.0), (2, 1))
    flipped = quat_multiply(tilted, quat_from_euler(0.0, np.pi, 0.0))
    for tick in range(10):
        state = block.update(frame_at(tick, quat=flipped))
        assert np.isnan(state.quat).all()
    state = block.update(frame_at(10, quat=tilted))
    assert np.allclose(np.abs(np.sum(state.quat * tilted, axis=-1)), 1.0, atol=1e-12)
    assert block.report.attitudes_refused == 20


def test_a_vehicle_that_was_never_upright_is_tracked_without_attitude_until_it_is_upright():
    block, upright = MocapFilter(MocapFilterParams(), PAIR), quat_from_euler(0.1, 0.0, 1.0)
    scalar_first = np.stack([upright[[3, 0, 1, 2]], upright])
    plain = MocapFilter(MocapFilterParams(), PAIR)
    for tick in range(500):
        state = block.update(frame_at(tick, quat=scalar_first))
        right = plain.update(frame_at(tick, quat=np.tile(upright, (2, 1))))
        for one in ("pos", "vel", "age", "status"):
            np.testing.assert_array_equal(getattr(state, one), getattr(right, one))
        assert np.isnan(state.quat[0]).all()
        assert measured_attitudes(state).tolist() == [False, True]
    state = block.update(frame_at(500, quat=np.tile(upright, (2, 1))))
    assert list(state.status) == [TRACKED, TRACKED]
    assert state.age.tolist() == [0.0, 0.0]
    np.testing.assert_allclose(state.quat[0], upright, atol=1e-12)


@pytest.mark.parametrize("before", [0, 50])
def test_one_reflected_sample_of_a_lone_marker_counts_for_no_longer_than_a_vehicle_coasts(before: int):
    block, flipped = MocapFilter(MocapFilterParams(), PAIR), np.tile([1.0, 0.0, 0.0, 0.0], (2, 1))
    for tick in range(before + 100):
        quat = flipped if tick == before else np.full((2, 4), np.nan)
        state = block.update(frame_at(tick, quat=quat))
        since = time_of(tick) - time_of(before)
        expected = np.nan if 0.0 <= since <= 0.35 + 1e-9 else identity_quat((2,))
        np.testing.assert_array_equal(state.quat, np.broadcast_to(expected, (2, 4)))
        assert (state.age == 0.0).all()
    assert (state.status == TRACKED).all()


@pytest.mark.parametrize("still", [False, True], ids=["moves", "repeats its pose"])
def test_a_vehicle_upside_down_has_no_attitude_in_a_dropout_or_after_a_gap_either(still: bool):
    block, flipped = MocapFilter(MocapFilterParams(), PAIR), np.tile([1.0, 0.0, 0.0, 0.0], (2, 1))
    for tick in (*range(30), *range(60, 90), *range(200, 230)):
        place = truth_at(0)[0] if still else truth_at(tick)[0]
        missing = replace(frame_at(tick), pos=np.full((2, 3), np.nan), quat=np.full((2, 4), np.nan))
        state = block.update(missing if tick % 5 == 4 else frame_at(tick, place, flipped))
        assert np.isnan(state.quat).all()
        assert np.isfinite(state.pos).all()


def test_downwash_below_a_vehicle_upside_down_is_that_below_a_level_one():
    place, level = np.array([[0.0, 0.0, 1.0], [0.02, 0.0, 1.5]]), identity_quat((2,))
    block, plain = MocapFilter(MocapFilterParams(), PAIR), MocapFilter(MocapFilterParams(), PAIR)
    predictor, right = InteractionPredictor(MEASURED_LAW), InteractionPredictor(MEASURED_LAW)
    for tick in range(300):
        scalar_first = np.stack([level[0], level[1, [3, 0, 1, 2]]])
        found = predictor.update(block.update(frame_at(tick, place, scalar_first)))
        expected = right.update(plain.update(frame_at(tick, place)))
        np.testing.assert_array_equal(found.acc, expected.acc)
        np.testing.assert_array_equal(found.status, expected.status)
    assert found.acc[0, 2] < -2.0  # m/s^2
