"""Poses that repeat bit for bit: those of a vehicle at rest are samples, those of a frozen stream are not."""

from copy import deepcopy

import numpy as np
import pytest
from steady_tracks import COAST, DT, FROZEN, NEAR, NOBODY, NONE, PLACES, flown, offered, tracks

from q2q_model.estimation.association.outlier_thresholds import REPEAT_STEP
from q2q_model.estimation.position.position_gates import VARIED
from q2q_model.estimation.position.position_prediction import THAW_STEP
from q2q_model.estimation.position.position_tracks import SETTLED, PositionTracks
from q2q_model.signals.values import Array

EVERYBODY = np.ones(2, dtype=bool)


def last_taken(made: PositionTracks, again: Array, first: int, count: int) -> list[int]:
    """Return the ticks, from `first` on, in which the first track takes a pose that repeats."""
    ticks = range(first, first + count)
    return [k - first for k in ticks if made.update(k * DT, again, EVERYBODY).accepted[0]]


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


def test_an_old_pose_again_is_no_sample_of_a_vehicle_that_should_have_moved() -> None:
    for speed, taken in ((0.9 * REPEAT_STEP / DT, True), (1.1 * REPEAT_STEP / DT, False)):
        vel = np.array([[0.0, speed, 0.0], [0.0, 0.0, 0.0]])
        made = flown(60, vel=vel)
        again = PLACES + 59 * DT * vel
        assert made.update(60 * DT, again, EVERYBODY).accepted.tolist() == [taken, True]


@pytest.mark.parametrize("speed", [0.09, 0.1, 0.12])
def test_a_pose_is_old_once_its_vehicle_should_have_moved_since_it_first_came(speed: float) -> None:
    """Below REPEAT_STEP a tick; the track then keeps most of its velocity instead of coming to rest."""
    assert speed * DT < REPEAT_STEP
    vel = np.array([[0.0, speed, 0.0], [0.0, 0.0, 0.0]])
    made, again = flown(60, vel=vel), PLACES + 59 * DT * vel
    verdicts = [made.update(k * DT, again, EVERYBODY) for k in range(60, 70)]
    taken = [bool(one.accepted[0]) for one in verdicts]
    assert taken == [True] + [False] * 9
    assert 0.6 * speed < verdicts[-1].vel[0, 1] < speed


def test_a_single_new_pose_in_a_frozen_stream_is_no_vehicle_that_was_found() -> None:
    made = tracks()
    hovering(made, 0, 30)
    again = leaving(made, 30, 30)
    assert last_taken(made, again, 60, 60) == []
    made.update(120 * DT, again + 0.1, NOBODY)
    assert last_taken(made, again + 0.1, 121, 60) == []


def test_a_pose_that_froze_in_spite_of_noise_is_not_accepted_until_a_vehicle_may_have_landed() -> None:
    made = tracks()
    hovering(made, 0, 30)
    again = leaving(made, 30, 30)
    accepted = round((FROZEN + COAST) / DT)  # the patience for a pose that repeats
    taken = last_taken(made, again, 60, accepted + 10)
    assert taken[0] == pytest.approx(accepted, abs=2)
    assert taken == list(range(taken[0], accepted + 10))


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
        assert made.update(k * DT, again, EVERYBODY).accepted.all()
    verdict = made.update(76 * DT, PLACES + 76 * DT * vel, np.array([False, True]))
    assert verdict.restarted.tolist() == [True, False]
    assert verdict.trusted.all()
    np.testing.assert_allclose(verdict.vel, vel, atol=0.01)
    np.testing.assert_allclose(verdict.pos[0], PLACES[0] + 76 * DT * vel[0], atol=1e-9)


def test_a_step_after_repeated_poses_is_taken_as_usual_up_to_its_bound() -> None:
    made = flown(60)
    for k in range(60, 76):
        made.update(k * DT, PLACES, EVERYBODY)
    for beyond, restarted in ((-NEAR, False), (NEAR, True)):
        place = PLACES[0] + (THAW_STEP + beyond) * np.array([0.48, 0.6, 0.64])
        verdict = offered(deepcopy(made), 76 * DT, place)
        assert verdict.restarted.tolist() == [restarted, False]
        assert not offered(flown(76), 76 * DT, place).restarted.any()  # without repeated ones before


@pytest.mark.parametrize("speed", [0.0, 0.5])
def test_names_stay_exchanged_while_the_poses_of_vehicles_that_stand_repeat(speed: float) -> None:
    """Without noise; the names are right again after longer than any patience. A third vehicle flies on."""
    made, places = tracks(count=3), np.vstack([PLACES, [[-3.0, 0.0, 1.0]]])
    vel = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, speed, 0.0]])
    settled, wrong = SETTLED + 10, round(2.0 * (FROZEN + COAST) / DT)
    for k in range(settled + wrong + 20):
        exchanged = settled <= k < settled + wrong
        order = [1, 0, 2] if exchanged else [0, 1, 2]
        stands = k not in {0, settled, settled + wrong}
        repeats = np.array([stands, stands, stands and not speed])
        pos = places + k * DT * vel
        found = made.update(k * DT, pos[order], repeats)
        assert found.source.tolist() == order
        assert not found.restarted.any()
        np.testing.assert_allclose(found.pos[:2], PLACES, atol=1e-9)


@pytest.mark.parametrize(("off", "taken"), [(0.9 * THAW_STEP, True), (1.1 * THAW_STEP, False)])
def test_a_pose_that_repeats_is_of_another_vehicle_only_where_that_one_stands(
    off: float, *, taken: bool
) -> None:
    made = flown(SETTLED + 10)
    beside = np.stack([PLACES[1] + [0.0, 0.0, off], NONE])
    found = made.update((SETTLED + 10) * DT, beside, EVERYBODY)
    assert found.source.tolist() == [-1, 0 if taken else -1]
