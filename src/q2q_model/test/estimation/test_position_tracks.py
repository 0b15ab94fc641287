"""Tracks of positions, tick by tick: every gate on both sides of its bound."""

from copy import deepcopy

import numpy as np
import pytest
from steady_tracks import COAST, DT, JERK, NEAR, NOBODY, NOISE, NONE, PLACES, flown, offered, tracks

from q2q_model.estimation.position import kalman_filter
from q2q_model.estimation.position.position_tracks import MOST_BORROWED, SETTLED


def spread(ticks: int) -> float:
    """Return the variance of a predicted position after so many samples [m^2]."""
    track, elapsed = kalman_filter.start(PLACES, np.zeros((2, 3)), NOISE**2), np.full(2, DT)
    for _ in range(ticks - 1):
        ahead = kalman_filter.predict(track, elapsed, JERK**2)
        track = kalman_filter.correct(ahead, PLACES, kalman_filter.gain(ahead, NOISE**2), NOISE**2)
    return float(kalman_filter.predict(track, elapsed, JERK**2).cov[0, 0, 0])


@pytest.mark.parametrize("speed_max", [2.0, 0.1])
def test_a_sample_is_taken_within_gate_and_reach(speed_max: float) -> None:
    made = flown(20, speed_max)
    size = min(0.25 + np.sqrt(spread(20) + NOISE**2), 0.25 + speed_max * DT)
    for beyond, taken in ((-NEAR, True), (NEAR, False)):
        place = PLACES[0] + (size + beyond) * np.array([0.48, 0.6, 0.64])
        verdict = deepcopy(made).update(20 * DT, np.stack([place, PLACES[1]]), NOBODY)
        assert verdict.accepted.tolist() == [taken, True]
        assert verdict.trusted.tolist() == [False, True]
        assert verdict.source.tolist() == [0 if taken else -1, 1]


def test_a_sample_that_is_taken_is_trusted_within_jump_max_or_once_the_next_one_agrees() -> None:
    for beyond, trusted in ((-NEAR, True), (NEAR, False)):
        made = flown(20, 2.0)
        place = PLACES[0] + (0.25 + beyond) * np.array([0.48, 0.6, 0.64])
        found = [made.update(k * DT, np.stack([place, PLACES[1]]), NOBODY) for k in (20, 21)]
        assert [one.accepted.tolist() for one in found] == [[True, True]] * 2
        assert [one.trusted.tolist() for one in found] == [[trusted, True], [True, True]]


def test_a_sample_out_of_the_room_is_none() -> None:
    made = tracks()
    for k in range(3):
        edge = np.array([[0.0, -8.0, 0.0], [0.0, 0.0, 8.0]])
        assert made.update(k * DT, edge, NOBODY).accepted.all()
    assert not made.update(3 * DT, edge * (1.0 + NEAR), NOBODY).accepted.any()


def test_a_track_coasts_and_is_then_lost_its_place_held_and_at_rest() -> None:
    vel = np.array([[0.5, 0.0, 0.0], [0.0, 0.0, 0.0]])
    made, last = flown(120, vel=vel), 119 * DT
    for k in range(120, 119 + 16 + 1):  # 0.25 s are 16 ticks
        verdict = made.update(k * DT, np.stack([NONE, PLACES[1]]), NOBODY)
        assert verdict.accepted.tolist() == [False, True]
        np.testing.assert_allclose(verdict.pos[0], PLACES[0] + [0.5 * k * DT, 0.0, 0.0], atol=1e-6)
        np.testing.assert_allclose(verdict.vel[0], [0.5, 0.0, 0.0], atol=1e-5)
    assert made.age(135 * DT).tolist() == [0.25, 0.0]
    lost = made.update(136 * DT, np.stack([NONE, PLACES[1]]), NOBODY)
    np.testing.assert_allclose(lost.pos[0], PLACES[0] + [0.5 * (last + COAST), 0.0, 0.0], atol=1e-6)
    assert lost.vel[0].tolist() == [0.0, 0.0, 0.0]
    back = made.update(137 * DT, np.stack([lost.pos[0], PLACES[1]]), NOBODY)  # once lost, none passes at once
    assert back.accepted.tolist() == [False, True]


@pytest.mark.parametrize("right", [6, 50])
def test_a_track_takes_anothers_samples_as_often_as_it_was_right_and_is_then_convinced(right: int) -> None:
    """Right, then swapped for good: borrowed as often, or 35 times; none until the rival is 0.125 s old."""
    made, seen = flown(right), []
    most = max(right, MOST_BORROWED)
    for k in range(right, right + most + 12):
        verdict = made.update(k * DT, PLACES[::-1].copy(), NOBODY)
        lines = {"borrowed": verdict.borrowed, "new": verdict.restarted, "own": verdict.accepted}
        seen.append(next((word for word, whose in lines.items() if whose.all()), "none"))
        assert verdict.borrowed.all() or not verdict.borrowed.any()
        if verdict.borrowed.all():
            np.testing.assert_allclose(verdict.pos, PLACES, atol=1e-9)
    assert seen == ["borrowed"] * most + ["none"] * 8 + ["new"] + ["own"] * 3


def test_a_settled_track_goes_on_by_its_motion_whatever_its_samples_are_called() -> None:
    made = flown(SETTLED)
    for k in range(SETTLED, 4 * SETTLED):
        verdict = made.update(k * DT, PLACES[::-1].copy(), NOBODY)
        assert verdict.borrowed.all()
        np.testing.assert_allclose(verdict.pos, PLACES, atol=1e-9)
    assert made.update(4 * SETTLED * DT, PLACES, NOBODY).source.tolist() == [0, 1]


@pytest.mark.parametrize(("off", "accepted"), [(0.25 - NEAR, [True, True]), (0.25 + NEAR, [False, True])])
def test_a_first_sample_of_another_name_is_accepted_near_the_path_of_one_that_coasts(
    off: float, accepted: list[bool]
) -> None:
    """Beyond 0.25 m it may be an outlier that is there by chance, until a second one agrees."""
    made = flown(SETTLED)
    for k in range(SETTLED, SETTLED + 12):  # 0.19 s: the gate grows to 0.29 m
        made.update(k * DT, np.stack([PLACES[0], NONE]), NOBODY)
    called_wrong = np.stack([PLACES[1] + [off, 0.0, 0.0], NONE])
    found = [made.update(k * DT, called_wrong, NOBODY) for k in (SETTLED + 12, SETTLED + 13)]
    assert [one.borrowed.tolist() for one in found] == [[False, borrowed] for borrowed in accepted]
    assert [one.accepted[0] for one in found] == [False, False]


def test_a_jump_that_lasts_is_accepted_with_the_velocity_it_has() -> None:
    made = flown(6)
    output = []
    for k in range(6, 15):  # 0.125 s are 8 ticks
        place = PLACES[0] + [0.0, 2.0, (k - 6) * DT]  # 1 m/s upwards
        verdict = offered(made, k * DT, place)
        output.append(bool(verdict.restarted[0]))
    assert output == [False] * 8 + [True]
    np.testing.assert_allclose(verdict.pos[0], place, atol=1e-12)
    np.testing.assert_allclose(verdict.vel[0], [0.0, 0.0, 1.0], atol=1e-12)
    assert verdict.trusted.tolist() == [True, True]


@pytest.mark.parametrize(("step", "vel"), [(0.45, 1.8), (0.55, 0.0)])
def test_a_first_sample_that_the_second_does_not_follow_from_is_forgotten(step: float, vel: float) -> None:
    """Over 0.25 s the gate is 0.4 m wide; what is slower than 2 m/s is taken for its velocity."""
    made = tracks(count=1)
    first = made.update(0.0, PLACES[:1], NOBODY[:1])
    assert (first.accepted.tolist(), first.trusted.tolist()) == ([True], [False])
    again = made.update(0.25, PLACES[:1] + np.array([step, 0.0, 0.0]), NOBODY[:1])
    assert (again.accepted.tolist(), again.trusted.tolist()) == ([True], [False])
    np.testing.assert_allclose(again.pos, PLACES[:1] + np.array([step, 0.0, 0.0]), atol=1e-15)
    np.testing.assert_allclose(again.vel, [[vel, 0.0, 0.0]], atol=1e-12)
    trusted = []
    for k in (1, 2):  # as one was refuted, two more must pass
        place = PLACES[:1] + np.array([step + vel * k * DT, 0.0, 0.0])
        trusted += made.update(0.25 + k * DT, place, NOBODY[:1]).trusted.tolist()
    assert trusted == [False, True]


def test_vehicles_that_are_added_were_never_seen() -> None:
    made = flown(60)
    made.grow(1)
    assert made.age(60 * DT).tolist() == [DT, DT, np.inf]
    verdict = made.update(60 * DT, np.concatenate([PLACES, [[5.0, 5.0, 5.0]]]), np.zeros(3, dtype=bool))
    assert verdict.accepted.tolist() == [True] * 3
    assert verdict.trusted.tolist() == [True, True, False]
    np.testing.assert_allclose(verdict.pos, [*PLACES.tolist(), [5.0, 5.0, 5.0]], atol=1e-12)
    unseen = tracks().update(0.0, np.full((2, 3), np.nan), NOBODY)
    assert not unseen.accepted.any()
    assert not unseen.pos.any()
    assert not unseen.vel.any()


def test_exchanged_labels_stay_doubtful_while_a_third_track_has_the_sample_of_one() -> None:
    places, moved = np.array([[0.0, 0.0, 1.0], [3.0, 0.0, 1.0], [6.0, 0.0, 1.0]]), np.array([0.0, 1.0, 0.0])
    made, nobody = tracks(count=3), np.zeros(3, dtype=bool)
    for k in range(20):
        made.update(k * DT, places, nobody)
    exchanged = np.stack([places[1] + moved, places[0] + moved, places[2]])
    for k in range(20, 28):
        assert not made.update(k * DT, exchanged, nobody).restarted.any()
    verdict = made.update(28 * DT, exchanged[[2, 1, 0]], nobody)  # REACQUIRE has passed
    assert verdict.source.tolist() == [-1, -1, 0]
    assert not verdict.restarted.any()
