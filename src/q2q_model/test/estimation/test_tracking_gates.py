"""The mocap filter's gates at their bounds, block by block: rivals, swaps, the compiled tick, attitudes."""

import math

import numpy as np
import pytest

from q2q_model.estimation.association.label_swaps import swapped_sources
from q2q_model.estimation.association.outlier_thresholds import OutlierThresholds
from q2q_model.estimation.association.reacquisition import CONFIRM_SAMPLES, Reacquisition
from q2q_model.estimation.association.suspected_swaps import LastSample, Unmatched
from q2q_model.estimation.attitude.attitude_steps import UNIT_TOLERANCE, AttitudeGateParams
from q2q_model.estimation.attitude.attitude_tracks import AttitudeTracks
from q2q_model.signals.values import Array, Mask

LIMITS = OutlierThresholds(speed_max=2.0, jump_max=0.25)
"""Exact in binary, as the times below, so that a bound is met exactly."""
DT = 0.125
ONE: Mask = np.ones(1, dtype=bool)
LEVEL = np.array([0.0, 0.0, 0.0, 1.0])


def resting(pos: Array, time: Array) -> LastSample:
    return LastSample(pos, np.zeros_like(pos), time, np.ones(len(pos), dtype=np.bool_))


def offered(
    places: list[float], patience: float = 0.0, start: float = 4.0
) -> tuple[Reacquisition, list[bool]]:
    """Return what became of refused samples at x = places, DT apart."""
    rivals = Reacquisition(1, LIMITS)
    return rivals, [
        bool(
            rivals.offer(
                start + k * DT, np.array([[x, 0.0, 0.0]]), ONE, np.full(1, patience)
            )[0]
        )
        for k, x in enumerate(places)
    ]  # fmt: skip


def test_a_rival_is_accepted_at_its_third_sample_where_it_may_at_once() -> None:
    assert CONFIRM_SAMPLES == 3
    assert offered([1.0, 1.0, 1.0, 1.0])[1] == [False, False, True, True]


def test_a_rival_must_last_as_long_as_is_asked_and_no_longer() -> None:
    assert offered([1.0] * 5, patience=3 * DT)[1] == [False, False, False, True, True]


def test_a_sample_joins_up_to_its_reach_and_starts_anew_beyond() -> None:
    reach = LIMITS.jump_max + LIMITS.speed_max * DT  # 0.5 m
    assert offered([1.0, 1.0 + reach, 1.0 + 2 * reach])[1] == [False, False, True]
    assert offered([1.0, 1.0, 1.0 + reach + 1e-9, 1.0, 1.0])[1] == [False, False, False, False, False]


def test_a_forgotten_rival_begins_again_and_only_refused_samples_count() -> None:
    rivals, _ = offered([1.0, 1.0])
    rivals.forget(ONE)
    place, at_once = np.array([[1.0, 0.0, 0.0]]), np.zeros(1)
    assert not rivals.offer(4.25, place, ONE, at_once)[0]
    assert not rivals.offer(4.3125, place, ~ONE, at_once)[0]
    assert not rivals.offer(4.375, place, ONE, at_once)[0]
    assert not rivals.offer(4.4375, place, ONE, at_once)[0]  # the third, but more than half is one gap
    assert rivals.offer(4.5, place, ONE, at_once)[0]


@pytest.mark.parametrize(("place", "doubtful"), [(1.25, True), (0.75, False), (2.25, True)])
def test_a_refused_sample_is_doubtful_where_it_is_nearer_to_an_absent_vehicle(
    place: float, *, doubtful: bool
) -> None:
    """The other was last at x = 2, 1/8 s ago, the sample's own vehicle at 0."""
    last, when = np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]]), np.array([4.0, 4.125])
    pos = np.array([[place, 0.0, 0.0], [np.nan] * 3])
    absent = Unmatched(absent=np.array([False, True]), rejected=np.array([True, False]))
    output = Reacquisition(2, LIMITS).update_ambiguous(4.25, pos, resting(last, when), absent)
    assert output.tolist() == [doubtful, False]


@pytest.mark.parametrize(("speed", "doubtful"), [(-2.0, True), (0.0, False), (2.0, False)])
def test_a_refused_sample_is_doubtful_where_an_absent_vehicle_would_be_by_its_last_velocity(
    speed: float, *, doubtful: bool
) -> None:
    """The other was last at x = 2, 1/2 s ago; the sample is at 0.75, nearer to its own vehicle at 0."""
    last = LastSample(
        pos=np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]]),
        vel=np.array([[0.0, 0.0, 0.0], [speed, 0.0, 0.0]]),
        time=np.array([4.0, 3.75]),
        coasting=np.zeros(2, dtype=np.bool_),
    )
    pos = np.array([[0.75, 0.0, 0.0], [np.nan] * 3])
    absent = Unmatched(absent=np.array([False, True]), rejected=np.array([True, False]))
    assert Reacquisition(2, LIMITS).update_ambiguous(4.25, pos, last, absent).tolist() == [doubtful, False]


@pytest.mark.parametrize(("place", "doubtful"), [(1.25, True), (0.75, False)])
def test_a_refused_sample_is_doubtful_where_it_is_nearer_to_another_that_is_refused(
    place: float, *, doubtful: bool
) -> None:
    last, when = np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]]), np.full(2, 4.125)
    pos = np.array([[place, 0.0, 0.0], [9.0, 0.0, 0.0]])
    refused = Unmatched(absent=np.zeros(2, dtype=bool), rejected=np.ones(2, dtype=bool))
    assert Reacquisition(2, LIMITS).update_ambiguous(4.25, pos, resting(last, when), refused).tolist() == [
        doubtful,
        False,
    ]


def test_a_doubt_lasts_while_another_vehicle_is_missing_and_no_longer() -> None:
    rivals = Reacquisition(2, LIMITS)
    last, when = np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]]), np.full(2, 4.125)
    near, far = np.array([[1.25, 0.0, 0.0], [9.0, 0.0, 0.0]]), np.array([[1.0, 0.0, 0.0], [np.nan] * 3])
    none, first, both = np.zeros(2, np.bool_), np.array([True, False]), np.ones(2, np.bool_)
    exchanged, vanished, returned = Unmatched(none, both), Unmatched(~first, first), Unmatched(none, first)

    def doubtful(pos: Array, unmatched: Unmatched) -> bool:
        return bool(rivals.update_ambiguous(4.25, pos, resting(last, when), unmatched)[0])

    assert not doubtful(far, vanished)
    assert doubtful(near, exchanged)
    rivals.offer(4.25, near, both, np.ones(2))
    assert doubtful(far, vanished)  # by what was seen before
    rivals.forget(first)
    assert not doubtful(far, vanished)
    assert doubtful(near, exchanged)
    assert not doubtful(far, returned)
    assert not doubtful(far, vanished)


def test_a_sample_goes_to_the_nearest_needy_track_within_its_gate_and_never_to_its_own() -> None:
    measured = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [np.nan] * 3])
    expected = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.25, 0.0, 0.0]])
    needy = np.ones(3, dtype=bool)
    orphans = np.array([True, True, False])
    assert swapped_sources(measured, expected, np.full(3, 0.5), orphans, needy).tolist() == [1, 0, -1]
    # row 1 is alone: track 0 is right, and itself is no other
    alone = np.array([False, True, False])
    assert swapped_sources(measured, expected, np.full(3, 0.5), alone, needy).tolist() == [1, -1, -1]
    # track 2 is 0.25 m from row 0: within a gate of just that, not within less
    only = np.array([False, False, True])
    at = swapped_sources(measured, expected, np.full(3, 0.25), orphans, only)
    within = swapped_sources(measured, expected, np.full(3, 0.2499), orphans, only)
    assert (at.tolist(), within.tolist()) == ([-1, -1, 0], [-1, -1, -1])


PARAMS = AttitudeGateParams(
    turn_max=0.5, turn_rate_max=2.0, rate_filter_s=0.0, reacquire_s=0.5, flip_reacquire_s=2.0, coast_s=0.25
)


def yawed(angle: float, length: float = 1.0) -> Array:
    """Return a quaternion turned about z, (1, 4)."""
    return np.array([[0.0, 0.0, length * math.sin(angle / 2), length * math.cos(angle / 2)]])


def test_the_first_attitude_is_taken_and_made_a_unit_one() -> None:
    tracks = AttitudeTracks(PARAMS, 1)
    assert tracks.update(4.0, yawed(1.0, 1.04)) == 0
    np.testing.assert_allclose(tracks.quat[0], yawed(1.0)[0], atol=1e-15)


@pytest.mark.parametrize(("angle", "taken"), [(0.74, True), (0.76, False), (-0.74, True), (-0.76, False)])
def test_a_turn_is_accepted_up_to_its_bound(angle: float, taken: bool) -> None:
    gap = 0.125
    tracks = AttitudeTracks(PARAMS, 1)
    tracks.update(4.0, yawed(0.0))
    assert tracks.update(4.0 + gap, yawed(angle)) == int(not taken)  # 0.5 + 2 * 0.125 rad
    after = angle if taken else 0.0
    np.testing.assert_allclose(tracks.quat[0], yawed(after)[0], atol=1e-15)
    rate = angle / gap if taken else 0.0
    np.testing.assert_allclose(tracks.ang_vel_body[0], [0.0, 0.0, rate], atol=1e-12)


def test_a_refused_attitude_that_lasts_is_accepted_just_then_and_its_rate_unknown() -> None:
    tracks = AttitudeTracks(PARAMS, 1)
    tracks.update(4.0, yawed(0.0))
    refused = [tracks.update(4.125 + k * 0.125, yawed(3.0)) for k in range(5)]
    assert refused == [1, 1, 1, 1, 0]
    np.testing.assert_allclose(tracks.quat[0], yawed(3.0)[0], atol=1e-15)
    assert tracks.ang_vel_body[0].tolist() == [0.0, 0.0, 0.0]


@pytest.mark.parametrize(("gap", "known"), [(0.25, True), (0.375, False)])
def test_after_a_gap_longer_than_coasting_a_rate_is_not_made_up(gap: float, known: bool) -> None:
    tracks = AttitudeTracks(PARAMS, 1)
    tracks.update(4.0, yawed(0.0))
    tracks.update(4.0 + gap, yawed(0.3))
    assert tracks.ang_vel_body[0, 2] == pytest.approx(0.3 / gap if known else 0.0)


@pytest.mark.parametrize("wrong", [0.9, 1.1, np.nan, 0.0, 1e300])
def test_what_is_no_unit_quaternion_is_a_missing_one(wrong: float) -> None:
    tracks = AttitudeTracks(PARAMS, 1)
    tracks.update(4.0, yawed(0.2))
    with np.errstate(all="ignore"):
        assert tracks.update(4.125, wrong * yawed(0.4)) == 0
    np.testing.assert_allclose(tracks.quat[0], yawed(0.2)[0], atol=1e-15)
    assert tracks.ang_vel_body[0].tolist() == [0.0, 0.0, 0.0]


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_quaternion_is_taken_up_to_the_tolerance_of_its_length(side: float) -> None:
    for share, taken in ((0.99, True), (1.01, False)):
        tracks = AttitudeTracks(PARAMS, 1)
        tracks.update(4.0, yawed(0.2, 1.0 + side * share * UNIT_TOLERANCE))
        np.testing.assert_allclose(tracks.quat[0], yawed(0.2 if taken else 0.0)[0], atol=1e-15)


def test_the_nearer_of_two_attitudes_is_the_one_with_less_turn() -> None:
    tracks = AttitudeTracks(PARAMS, 1)
    tracks.update(4.0, yawed(0.0))
    near, far, none = yawed(0.2), yawed(0.4), np.full((1, 4), np.nan)
    for one, other in ((near, far), (far, near), (near, none), (none, near), (-near, far)):
        assert abs(tracks.nearest(one, other)[0, 2]) == pytest.approx(math.sin(0.1))


@pytest.mark.parametrize("column", range(4))
def test_a_quaternion_of_which_one_number_is_missing_is_none(column: int) -> None:
    tracks = AttitudeTracks(PARAMS, 1)
    tracks.update(4.0, yawed(0.0))
    damaged = yawed(0.1)
    damaged[0, column] = np.nan
    for k in range(1, 4):
        assert tracks.update(4.0 + k * DT, damaged) == 0
        assert tracks.ang_vel_body.tolist() == [[0.0, 0.0, 0.0]]
    tracks.update(4.5, yawed(0.3))
    assert tracks.ang_vel_body.tolist() == [[0.0, 0.0, 0.0]]  # unseen for longer than it coasts
    tracks.update(4.625, yawed(0.4))
    assert tracks.ang_vel_body[0, 2] == pytest.approx(0.1 / DT)


def test_vehicles_that_are_added_are_level_and_take_any_first_attitude() -> None:
    tracks = AttitudeTracks(PARAMS, 1)
    for k in range(3):
        tracks.update(4.0 + k * DT, yawed(0.1 * k))
    tracks.grow(1)
    np.testing.assert_array_equal(tracks.quat[1], LEVEL)
    assert tracks.update(4.375, np.concatenate([yawed(0.3), yawed(3.0)])) == 0
    np.testing.assert_allclose(tracks.quat, np.concatenate([yawed(0.3), yawed(3.0)]), atol=1e-15)
    np.testing.assert_allclose(tracks.ang_vel_body, [[0.0, 0.0, 0.1 / DT], [0.0, 0.0, 0.0]], atol=1e-12)
    lone = np.concatenate([np.full((1, 4), np.nan), yawed(3.1)])
    assert tracks.update(4.5, lone) == 0
    np.testing.assert_allclose(tracks.ang_vel_body, [[0.0, 0.0, 0.0], [0.0, 0.0, 0.1 / DT]], atol=1e-12)


@pytest.mark.parametrize("lag", [0.0, 0.125, 0.375])
def test_the_rate_follows_behind_its_low_pass(lag: float) -> None:
    tracks, blend = AttitudeTracks(PARAMS._replace(rate_filter_s=lag), 1), DT / (DT + lag)
    rate = 0.0
    for k in range(5):
        tracks.update(4.0 + k * DT, yawed(0.1 * k))
        rate += blend * ((0.1 / DT if k else 0.0) - rate)
        assert tracks.ang_vel_body[0, 2] == pytest.approx(rate)


@pytest.mark.parametrize(("gap", "known"), [(0.25, True), (0.25 + 1e-6, False)])
def test_beside_a_vehicle_that_was_never_seen_gaps_are_judged_the_same(gap: float, *, known: bool) -> None:
    unseen = np.full((1, 4), np.nan)
    tracks = AttitudeTracks(PARAMS, 2)
    tracks.update(4.0, np.concatenate([yawed(0.0), unseen]))
    assert tracks.update(4.0 + gap, np.concatenate([yawed(0.3, 1.04), unseen])) == 0
    assert tracks.ang_vel_body[0, 2] == pytest.approx(0.3 / gap if known else 0.0)
    np.testing.assert_allclose(tracks.quat[0], yawed(0.3)[0], atol=1e-15)
