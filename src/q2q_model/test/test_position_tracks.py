"""Tracks of positions, tick by tick: every gate on both sides of its bound."""

from copy import deepcopy

import numpy as np
import pytest

from q2q_model.estimation.position import white_jerk
from q2q_model.estimation.position.position_gates import VARIED
from q2q_model.estimation.position.position_steps import THAW_STEP
from q2q_model.estimation.position.position_tracks import BORROWED_MOST, SETTLED, PositionTracks, TrackUpdate
from q2q_model.estimation.position.track_columns import TrackParams
from q2q_model.flights.outliers import REPEAT_STEP
from q2q_model.signals.values import Array

DT = 1.0 / 64.0
NOISE, JERK, COAST, REACQUIRE, FROZEN = 0.01, 8.0, 0.25, 0.125, 2.0
NEAR = 1e-6
"""On this side or that of a bound [m]."""
PLACES = np.array([[0.0, 0.0, 1.0], [3.0, 0.0, 1.0]])
NOBODY = np.zeros(2, dtype=bool)
"""Vehicles whose pose is repeated."""
NONE = np.full(3, np.nan)


def tracks(speed_max: float = 2.0, count: int = 2) -> PositionTracks:
    return PositionTracks(TrackParams(8.0, speed_max, 0.25, NOISE, JERK, COAST, REACQUIRE, FROZEN), count)


def flown(ticks: int, speed_max: float = 2.0, vel: Array | None = None) -> PositionTracks:
    """Return tracks of two vehicles in uniform motion, with samples at ticks 0 .. ticks - 1."""
    made = tracks(speed_max)
    for k in range(ticks):
        made.update(k * DT, PLACES + (0.0 if vel is None else k * DT * vel), NOBODY)
    return made


def spread(ticks: int) -> float:
    """Return the variance of a predicted position after so many samples [m^2]."""
    track, elapsed = white_jerk.start(PLACES, np.zeros((2, 3)), NOISE**2), np.full(2, DT)
    for _ in range(ticks - 1):
        ahead = white_jerk.predict(track, elapsed, JERK**2)
        track = white_jerk.correct(ahead, PLACES, white_jerk.gain(ahead, NOISE**2), NOISE**2)
    return float(white_jerk.predict(track, elapsed, JERK**2).cov[0, 0, 0])


def offered(made: PositionTracks, t: float, first: Array, second: Array | None = None) -> TrackUpdate:
    """Return what becomes of a tick; the second vehicle is where it was."""
    return made.update(t, np.stack([first, PLACES[1] if second is None else second]), NOBODY)


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


def test_an_old_pose_again_is_no_sample_of_a_vehicle_that_should_have_moved() -> None:
    for speed, taken in ((0.9 * REPEAT_STEP / DT, True), (1.1 * REPEAT_STEP / DT, False)):
        vel = np.array([[0.0, speed, 0.0], [0.0, 0.0, 0.0]])
        made = flown(60, vel=vel)
        again = PLACES + 59 * DT * vel
        assert made.update(60 * DT, again, np.ones(2, dtype=bool)).accepted.tolist() == [taken, True]


@pytest.mark.parametrize("speed", [0.09, 0.1, 0.12])
def test_a_pose_is_old_once_its_vehicle_should_have_moved_since_it_first_came(speed: float) -> None:
    """Below REPEAT_STEP a tick; the track then keeps most of its velocity instead of coming to rest."""
    assert speed * DT < REPEAT_STEP
    vel = np.array([[0.0, speed, 0.0], [0.0, 0.0, 0.0]])
    made, again = flown(60, vel=vel), PLACES + 59 * DT * vel
    verdicts = [made.update(k * DT, again, np.ones(2, dtype=bool)) for k in range(60, 70)]
    taken = [bool(one.accepted[0]) for one in verdicts]
    assert taken == [True] + [False] * 9
    assert 0.6 * speed < verdicts[-1].vel[0, 1] < speed


EVERYBODY = np.ones(2, dtype=bool)


def last_taken(made: PositionTracks, again: Array, first: int, count: int) -> list[int]:
    """Return the ticks, from `first` on, in which the first track takes a pose that repeats."""
    ticks = range(first, first + count)
    return [k - first for k in ticks if made.update(k * DT, again, EVERYBODY).accepted[0]]


def test_a_single_new_pose_in_a_frozen_stream_is_no_vehicle_that_was_found() -> None:
    made = tracks()
    hovering(made, 0, 30)
    again = leaving(made, 30, 30)
    assert last_taken(made, again, 60, 60) == []
    made.update(120 * DT, again + 0.1, NOBODY)
    assert last_taken(made, again + 0.1, 121, 60) == []


def hovering(made: PositionTracks, first: int, count: int, noise: float = 2e-4) -> Array:
    """Let vehicles hover with noise [m] for `count` ticks from `first` on; return the last poses."""
    rng = np.random.default_rng(first)
    for k in range(first, first + count):
        seen = PLACES + noise * rng.uniform(0.5, 1.0, (2, 3))
        made.update(k * DT, seen, NOBODY)
    return seen


def leaving(made: PositionTracks, first: int, count: int) -> Array:
    """Let the first vehicle leave at 0.5 m/s, with noise; return the last poses."""
    rng = np.random.default_rng(first)
    for k in range(count):
        way = np.array([[0.5 * k * DT, 0.0, 0.0], [0.0, 0.0, 0.0]])
        seen = PLACES + way + rng.uniform(1e-4, 2e-4, (2, 3))
        made.update((first + k) * DT, seen, NOBODY)
    return seen


def test_a_pose_that_froze_in_spite_of_noise_is_not_believed_until_a_vehicle_may_have_landed() -> None:
    made = tracks()
    hovering(made, 0, 30)
    again = leaving(made, 30, 30)
    believed = round((FROZEN + COAST) / DT)  # the patience for a pose that repeats
    taken = last_taken(made, again, 60, believed + 10)
    assert taken[0] == pytest.approx(believed, abs=2)
    assert taken == list(range(taken[0], believed + 10))


def test_another_pose_ends_a_frozen_stream_at_once() -> None:
    made = tracks()
    hovering(made, 0, 30)
    again = leaving(made, 30, 30)
    assert last_taken(made, again, 60, 80) == []
    vel = np.array([[0.5, 0.0, 0.0], [0.0, 0.0, 0.0]])
    there = [made.update(k * DT, PLACES + (k - 30) * DT * vel, NOBODY) for k in range(140, 160)]
    assert [bool(one.trusted[0]) for one in there] == [False] * 8 + [True] * 12  # REACQUIRE
    np.testing.assert_allclose(there[-1].vel[0], vel[0], atol=0.01)


@pytest.mark.parametrize(("samples", "taken"), [(VARIED - 1, True), (VARIED, False)])
def test_a_pose_that_repeats_in_a_hover_is_old_where_noise_keeps_poses_apart(
    samples: int, *, taken: bool
) -> None:
    made = tracks()
    again = hovering(made, 0, samples)
    assert bool(last_taken(made, again, samples, 10)) == taken


def test_a_pose_may_repeat_where_poses_have_done_so_are_rounded_or_without_noise() -> None:
    made = tracks()
    again = hovering(made, 0, VARIED - 5)
    assert len(last_taken(made, again, VARIED - 5, 10)) == 10
    again = hovering(made, VARIED + 5, VARIED - 5)
    assert len(last_taken(made, again, 2 * VARIED, 10)) == 10
    smooth = tracks()
    hovering(smooth, 0, 50)
    again = hovering(smooth, 50, 60, 1e-7)
    assert len(last_taken(smooth, again, 110, 10)) == 10
    rounded = tracks()
    for k in range(50):
        again = np.round(PLACES + (k % 3) * 1e-4, 4)
        rounded.update(k * DT, again, NOBODY)
    assert len(last_taken(rounded, again, 50, 10)) == 10


def test_a_vehicle_that_stands_where_it_is_found_after_a_gap_is_found() -> None:
    """Its pose repeats since it is seen again, and has not while it flew."""
    vel = np.array([[0.5, 0.0, 0.0], [0.0, 0.0, 0.0]])
    made = flown(60, vel=vel)
    for k in range(60, 90):
        made.update(k * DT, np.stack([NONE, PLACES[1]]), NOBODY)
    made.update(90 * DT, PLACES, NOBODY)
    assert last_taken(made, PLACES, 91, 40)[0] == round(COAST / DT) - 1


def test_positions_rounded_to_millimetres_are_samples_at_any_speed() -> None:
    """As recorded flights have them; bit for bit the same only while the vehicle moves by less than 1 mm."""
    for speed in (0.002, 0.02, 0.06, 0.1, 0.3):
        made, seen = tracks(count=1), [np.full((1, 3), np.nan)]
        for k in range(200):
            place = np.round(np.array([[0.0, speed * k * DT, 1.0]]), 3)
            verdict = made.update(k * DT, place, (place == seen[-1]).all(axis=1))
            assert verdict.accepted.all()
            seen.append(place)


def test_a_pose_that_shows_repeated_ones_to_be_old_restarts_its_track_at_their_mean_velocity() -> None:
    vel = np.array([[0.05, 0.0, 0.0], [0.0, 0.0, 0.0]])
    made, again = flown(60, vel=vel), PLACES + 59 * DT * vel
    for k in range(60, 76):
        assert made.update(k * DT, again, np.ones(2, dtype=bool)).accepted.all()
    verdict = made.update(76 * DT, PLACES + 76 * DT * vel, np.array([False, True]))
    assert verdict.restarted.tolist() == [True, False]
    assert verdict.trusted.all()
    np.testing.assert_allclose(verdict.vel, vel, atol=0.01)
    np.testing.assert_allclose(verdict.pos[0], PLACES[0] + 76 * DT * vel[0], atol=1e-9)


def test_a_step_after_repeated_poses_is_taken_as_usual_up_to_its_bound() -> None:
    made = flown(60)
    for k in range(60, 76):
        made.update(k * DT, PLACES, np.ones(2, dtype=bool))
    for beyond, restarted in ((-NEAR, False), (NEAR, True)):
        place = PLACES[0] + (THAW_STEP + beyond) * np.array([0.48, 0.6, 0.64])
        verdict = offered(deepcopy(made), 76 * DT, place)
        assert verdict.restarted.tolist() == [restarted, False]
        assert not offered(flown(76), 76 * DT, place).restarted.any()  # without repeated ones before


@pytest.mark.parametrize("right", [6, 50])
def test_a_track_takes_anothers_samples_as_often_as_it_was_right_and_is_then_convinced(right: int) -> None:
    """Right, then swapped for good: lent as often, or 35 times; refused until the rival is 0.125 s old."""
    made, seen = flown(right), []
    most = max(right, BORROWED_MOST)
    for k in range(right, right + most + 12):
        verdict = made.update(k * DT, PLACES[::-1].copy(), NOBODY)
        lines = {"lent": verdict.lent, "new": verdict.restarted, "own": verdict.accepted}
        seen.append(next((word for word, whose in lines.items() if whose.all()), "none"))
        assert verdict.lent.all() or not verdict.lent.any()
        if verdict.lent.all():
            np.testing.assert_allclose(verdict.pos, PLACES, atol=1e-9)
    assert seen == ["lent"] * most + ["none"] * 8 + ["new"] + ["own"] * 3


def test_a_settled_track_goes_on_by_its_motion_whatever_its_samples_are_called() -> None:
    made = flown(SETTLED)
    for k in range(SETTLED, 4 * SETTLED):
        verdict = made.update(k * DT, PLACES[::-1].copy(), NOBODY)
        assert verdict.lent.all()
        np.testing.assert_allclose(verdict.pos, PLACES, atol=1e-9)
    assert made.update(4 * SETTLED * DT, PLACES, NOBODY).source.tolist() == [0, 1]


def test_a_jump_that_lasts_is_believed_with_the_velocity_it_has() -> None:
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
