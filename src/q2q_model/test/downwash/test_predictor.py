"""Tests of the online predictor against the law summed by hand, and of its answers to bad input."""

from dataclasses import replace

import numpy as np
import pytest
from resting_signals import resting_state

from q2q_model.downwash.interaction_model import pairs_at_rest
from q2q_model.downwash.jet import MEASURED_LAW, PAPER_LAW, Jet
from q2q_model.downwash.no_interaction import NoInteraction
from q2q_model.downwash.predictor import InteractionPredictor
from q2q_model.downwash.state_history import StateHistory
from q2q_model.signals.some_vehicles import of_vehicles
from q2q_model.signals.values import Interference, InterferenceStatus, SwarmState, TrackStatus

LEVEL = pairs_at_rest(np.zeros(3))


def state(t: float, pos: list[list[float]], vel: list[list[float]] | None = None) -> SwarmState:
    """Return a tracked state of level vehicles."""
    n = len(pos)
    names = tuple(f"cf{k}" for k in range(1, n + 1))
    speed = np.zeros((n, 3)) if vel is None else np.array(vel, dtype=float)
    return resting_state(t, names, np.array(pos, dtype=float), vel=speed)


STACK = [[0.0, 0.0, 1.0], [0.02, 0.0, 1.5], [0.0, 0.03, 2.1]]


def fly_past(predictor: InteractionPredictor, ticks: int = 60) -> Interference:
    """Move a source along x at 1 m/s, 0.6 m above a hovering vehicle, to x = 0."""
    for k in range(ticks):
        t = 0.01 * k
        last = predictor.update(state(t, [[0, 0, 1.0], [t - 0.59, 0, 1.6]], [[0, 0, 0], [1.0, 0, 0]]))
    return last


def test_pushes_of_all_sources_add_up():
    answer = InteractionPredictor(PAPER_LAW).update(state(0.0, STACK))
    pos = np.array(STACK)
    for i in range(3):
        by_hand = sum(PAPER_LAW.acceleration(pos[j] - pos[i], LEVEL) for j in range(3) if j != i)
        np.testing.assert_allclose(answer.acc[i], by_hand, rtol=1e-12)
    assert (answer.status == InterferenceStatus.VALID).all()
    assert answer.acc[0, 2] < 0.0 < answer.acc[2, 2]


def test_a_moving_source_pushes_from_where_it_was_a_delay_ago():
    answer = fly_past(InteractionPredictor(MEASURED_LAW))
    behind = np.array([-0.6 / 7.5 * 1.0, 0.0, 0.6])  # 80 ms at 1 m/s, straight line: exact by interpolation
    expected = MEASURED_LAW.acceleration(behind, LEVEL)
    np.testing.assert_allclose(answer.acc[0], expected, rtol=1e-9)
    assert abs(answer.acc[0, 2]) < 0.5 * abs(MEASURED_LAW.acceleration(np.array([0, 0, 0.6]), LEVEL)[2])


def test_a_repeated_stamp_gets_the_same_answer_and_changes_no_memory():
    once, often = InteractionPredictor(MEASURED_LAW), InteractionPredictor(MEASURED_LAW)
    for k in range(30):
        now = state(0.01 * k, [[0, 0, 1.0], [0.01 * k - 0.2, 0, 1.5]])
        expected = once.update(now)
        for _ in range(3):
            np.testing.assert_array_equal(often.update(now).acc, expected.acc)


@pytest.mark.parametrize("off", [-1e9, -3.0, 3.0, 1e9])
def test_few_stamps_far_off_leave_no_trace(off: float) -> None:
    some, none = InteractionPredictor(MEASURED_LAW), InteractionPredictor(MEASURED_LAW)
    for k in range(60):
        now = state(0.01 * k, [[0, 0, 1.0], [0.01 * k - 0.59, 0, 1.6]], [[0, 0, 0], [1.0, 0, 0]])
        if 50 <= k < 55:
            some.update(replace(now, t=now.t + off))
        else:
            np.testing.assert_array_equal(some.update(now).acc, none.update(now).acc)


def test_a_clock_set_ahead_is_followed_once_its_stamps_have_risen() -> None:
    predictor = InteractionPredictor(MEASURED_LAW)
    fly_past(predictor)
    for k in range(60):
        t = 5.0 + 0.01 * k
        now = state(t, [[0, 0, 1.0], [t - 5.59, 0, 1.6]], [[0, 0, 0], [1.0, 0, 0]])
        answer = predictor.update(now)
    np.testing.assert_allclose(answer.acc, fly_past(InteractionPredictor(MEASURED_LAW)).acc, rtol=1e-9)


def test_a_bag_that_starts_again_gives_the_answers_of_the_first_time():
    predictor = InteractionPredictor(MEASURED_LAW)
    first = fly_past(predictor)
    np.testing.assert_array_equal(fly_past(predictor).acc, first.acc)


@pytest.mark.parametrize("off", [3.0, 1e9, -0.05, -0.5, -3.0])
@pytest.mark.parametrize("rows", [[0, 1], [1, 0], [0]])
def test_a_state_under_a_wrong_stamp_is_no_past_of_its_vehicles(off: float, rows: list[int]) -> None:
    right, got = InteractionPredictor(MEASURED_LAW), InteractionPredictor(MEASURED_LAW)
    for k in range(60):
        t = 0.01 * k
        now = state(t, [[0, 0, 1.0], [t - 0.4, 0, 1.6]], [[0, 0, 0], [1.0, 0, 0]])
        if k == 35:
            got.update(of_vehicles(replace(now, t=t + off), np.array(rows)))
        else:
            np.testing.assert_allclose(got.update(now).acc, right.update(now).acc, rtol=1e-12)


@pytest.mark.parametrize("off", [100.0, -100.0])
def test_a_clock_that_is_set_is_followed_after_a_tenth_of_a_second(off: float) -> None:
    predictor = InteractionPredictor(MEASURED_LAW)
    fly_past(predictor)
    for k in range(12):
        answer = predictor.update(state(off + 0.01 * k, [[0, 0, 1.0], [0.01 * k, 0, 1.6]]))
    behind = np.array([0.10, 0, 0.6])  # where its first state of the new clock was followed
    np.testing.assert_allclose(answer.acc[0], MEASURED_LAW.acceleration(behind, LEVEL), rtol=1e-9)


def test_a_source_that_is_only_guessed_is_announced_on_the_vehicle_it_pushes():
    now = state(0.0, [[0, 0, 1.0], [0, 0, 1.5], [5.0, 0, 1.0]])
    coasting = np.array([TrackStatus.TRACKED, TrackStatus.COASTING, TrackStatus.LOST], dtype=np.uint8)
    answer = InteractionPredictor(PAPER_LAW).update(replace(now, status=coasting))
    assert answer.status[0] == InterferenceStatus.STALE_SOURCE
    assert answer.acc[0, 2] < -0.3
    assert (
        answer.status[1] == answer.status[2] == InterferenceStatus.VALID
    )  # their sources are tracked, or none


@pytest.mark.parametrize("law", [PAPER_LAW, MEASURED_LAW])
def test_a_vehicle_with_nan_neither_feels_nor_causes_and_says_so(law: Jet):
    answer = InteractionPredictor(law).update(state(0.0, [[0, 0, 1.0], [0, np.nan, 1.5]]))
    np.testing.assert_array_equal(answer.acc, 0.0)
    assert list(answer.status) == [InterferenceStatus.VALID, InterferenceStatus.NO_MODEL]
    assert np.isnan(answer.std[1]).all()


@pytest.mark.parametrize("law", [PAPER_LAW, MEASURED_LAW])
def test_a_vehicle_that_was_never_seen_neither_feels_nor_causes_and_has_no_past(law: Jet) -> None:
    predictor = InteractionPredictor(law)
    now = state(0.0, [[0, 0, -0.5], [0, 0, 0]])
    unseen = replace(
        now,
        age=np.array([0.0, np.inf]),
        status=np.array([TrackStatus.TRACKED, TrackStatus.LOST], dtype=np.uint8),
    )
    answer = predictor.update(unseen)
    np.testing.assert_array_equal(answer.acc, 0.0)
    assert list(answer.status) == [InterferenceStatus.VALID, InterferenceStatus.NO_MODEL]
    seen = predictor.update(state(0.01, [[0, 0, -0.5], [9.0, 0, 0]]))
    np.testing.assert_allclose(seen.acc, 0.0, atol=1e-12)
    lost = replace(unseen, t=0.02, age=np.array([0.0, 5.0]))
    assert predictor.update(lost).acc[0, 2] < -0.3


def test_a_source_that_was_nan_when_its_air_left_is_announced():
    predictor = InteractionPredictor(MEASURED_LAW)
    for k in range(20):
        y = np.nan if k < 19 else 0.0
        answer = predictor.update(state(0.01 * k, [[0, 0, 1.0], [0, y, 1.6]]))
    assert answer.status[0] == InterferenceStatus.STALE_SOURCE
    assert answer.acc[0, 2] < -1.0


def test_vehicles_that_vanish_return_or_change_rows_keep_their_past():
    steady, shuffled = InteractionPredictor(MEASURED_LAW), InteractionPredictor(MEASURED_LAW)
    for k in range(40):
        t = 0.01 * k
        now = state(t, [[0, 0, 1.0], [t - 0.39, 0, 1.6], [9.0, 0, 1.0]])
        rows = [1, 0, 2] if k % 2 else [0, 1] if k < 20 else [2, 0, 1]
        expected, got = steady.update(now), shuffled.update(of_vehicles(now, np.array(rows)))
    np.testing.assert_allclose(got.acc[rows.index(0)], expected.acc[0], rtol=1e-9)


def test_without_a_model_nothing_pushes_and_the_status_says_so():
    answer = InteractionPredictor(NoInteraction()).update(state(0.0, STACK))
    np.testing.assert_array_equal(answer.acc, 0.0)
    assert (answer.status == InterferenceStatus.NO_MODEL).all()


@pytest.mark.parametrize("law", [PAPER_LAW, MEASURED_LAW, replace(MEASURED_LAW, absorption=1.5)])
def test_an_empty_swarm_gets_empty_answers_until_vehicles_come(law: Jet) -> None:
    predictor, nobody = InteractionPredictor(law), np.zeros(0, np.intp)
    for k in range(3):
        empty = predictor.update(of_vehicles(state(0.01 * k, STACK), nobody))
        assert empty.acc.shape == (0, 3)
    answer = predictor.update(state(0.03, STACK))
    np.testing.assert_array_equal(answer.acc, InteractionPredictor(law).update(state(0.0, STACK)).acc)


def test_variances_of_several_sources_add_up():
    law = Jet(relative_std=0.25, upper_ratio=0.0, spread=0.0)
    answer = InteractionPredictor(law).update(state(0.0, [[0, 0, 1.0], [0, 0, 1.5], [0, 0, 2.0]]))
    near, far = (0.25 * law.push(np.array([0.0, 0.0, dz]), LEVEL) for dz in (0.5, 1.0))
    assert answer.std[0, 2] == pytest.approx(np.hypot(near, far))


def test_the_deviation_is_affine_in_the_push():
    law = Jet(relative_std=0.25, std_floor=0.3, upper_ratio=0.0)
    answer = InteractionPredictor(law).update(state(0.0, [[0, 0, 1.0], [0, 0, 1.5]]))
    np.testing.assert_allclose(answer.std[:, 2], 0.3 + 0.25 * np.abs(answer.acc[:, 2]))
    assert np.abs(answer.acc[0, 2]) > 0.1


def test_exchanging_the_model_acts_at_the_next_stamp():
    predictor = InteractionPredictor(PAPER_LAW)
    before = predictor.update(state(0.0, STACK))
    predictor.exchange(Jet(strength=2 * PAPER_LAW.strength))
    np.testing.assert_allclose(predictor.update(state(0.01, STACK)).acc, 2 * before.acc, rtol=1e-12)


def test_history_interpolates_a_straight_line_exactly_however_long_it_runs():
    history = StateHistory(1, span=0.5)
    for k in range(1000):  # many times the first capacity
        history.push(0.01 * k, np.array([[0.02 * k, 0.0, 1.0, 2.0, 0.0, 0.0, 0.0, 0.0, 1.0]]))
    times = np.array([9.503, 9.7777, 9.99])
    found = history.at(times, np.zeros(3, dtype=np.intp))
    np.testing.assert_allclose(found[:, 0], 2.0 * times, rtol=1e-12)
    np.testing.assert_allclose(found[:, 3], 2.0)
    assert history.oldest == pytest.approx(9.49)  # one sample beyond the span, so that it is covered
    assert history.newest == pytest.approx(9.99)


def test_history_grows_when_the_span_holds_more_than_its_first_capacity():
    history = StateHistory(1, span=3.0)
    for k in range(1000):
        history.push(0.01 * k, np.array([[0.01 * k, *np.zeros(8)]]))
    found = history.at(np.array([7.0, 0.0]), np.zeros(2, dtype=np.intp))
    np.testing.assert_allclose(found[:, 0], [7.0, 6.99], rtol=1e-12)  # older than held: the oldest counts


def test_a_leaning_source_is_aimed_by_its_orientation():
    law = replace(MEASURED_LAW, carried=1.0)
    now = state(0.0, [[0, 0, 1.0], [0, 0, 1.5]])
    roll = np.array([np.sin(0.1), 0.0, 0.0, np.cos(0.1)])  # 0.2 rad: body z leans to -y, air goes to +y
    leaning = replace(now, quat=np.stack([now.quat[0], roll]))
    answer = InteractionPredictor(law).update(leaning)
    aside = replace(LEVEL, source_axis=np.array([0, -np.sin(0.2), np.cos(0.2)]))
    expected = law.acceleration(np.array([0, 0, 0.5]), aside)
    np.testing.assert_allclose(answer.acc[0], expected, rtol=1e-9)
    assert abs(answer.acc[0, 2]) < 0.5 * abs(InteractionPredictor(law).update(now).acc[0, 2])
    unknown = replace(now, quat=np.full((2, 4), np.nan))
    np.testing.assert_array_equal(
        InteractionPredictor(law).update(unknown).acc, InteractionPredictor(law).update(now).acc
    )
