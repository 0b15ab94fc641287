"""Gates of position samples, each on both sides of its bound, and the Kalman filter that predicts them."""

from copy import deepcopy
from itertools import pairwise

import numpy as np
import pytest

from q2q_model.estimation.association.outlier_thresholds import REPEAT_STEP
from q2q_model.estimation.position import kalman_filter
from q2q_model.estimation.position.kalman_filter import MotionEstimate
from q2q_model.estimation.position.position_gates import PositionGates, screen
from q2q_model.estimation.position.position_tracks import PositionTracks
from q2q_model.estimation.position.steady_gain import CONVERGED
from q2q_model.estimation.position.track_columns import TrackParams
from q2q_model.signals.stamps import SAME_INSTANT
from q2q_model.signals.values import Array, Mask
from q2q_model.vehicle.constants import GRAVITY

NEAR = 1e-9
"""Distance from a bound [m]: far above the rounding of a squared distance."""
DIRECTION = np.array([0.48, 0.6, 0.64])
"""Of unit length."""
ACROSS = np.array([0.8, 0.0, -0.6])
"""Normal to it, of unit length."""
GATES = PositionGates(
    last=np.array([[0.0, 0.0, 1.0]]),
    moved=np.zeros((1, 3)),
    expected=np.array([[0.0, 0.0, 1.0]]),
    reach=np.array([0.5]),
    deviation=np.array([0.25]),
    lost=np.array([False]),
    varies=np.array([False]),
    pos_max=8.0,
)
FRESH, REPEATED = np.array([False]), np.array([True])
LOST = GATES._replace(lost=np.array([True]))


def sample(distance: float) -> Array:
    return GATES.expected + distance * DIRECTION


def passed(measured: Array, gates: PositionGates, repeated: Mask = FRESH) -> bool:
    return bool(screen(measured, repeated, gates)[1][0])


@pytest.mark.parametrize(("beyond", "accepted"), [(-NEAR, True), (NEAR, False)])
def test_a_sample_passes_within_the_deviation_from_its_prediction(beyond: float, *, accepted: bool):
    assert passed(sample(0.25 + beyond), GATES) == accepted


@pytest.mark.parametrize(("beyond", "accepted"), [(-NEAR, True), (NEAR, False)])
def test_a_sample_passes_within_the_reach_of_the_last_one(beyond: float, *, accepted: bool):
    assert passed(sample(0.5 + beyond), GATES._replace(deviation=np.array([1.0]))) == accepted


@pytest.mark.parametrize(("beside", "accepted"), [(-NEAR, True), (NEAR, False)])
@pytest.mark.parametrize("share", [-1.0, -0.3, 0.0, 0.25, 1.0])
def test_a_sample_passes_beside_any_place_where_an_impact_may_put_it(
    share: float, beside: float, *, accepted: bool
):
    """Stopped on its way, or thrown back; DIRECTION is the way, ACROSS normal to it."""
    way = GATES._replace(expected=GATES.last + 0.4 * DIRECTION, reach=np.array([2.0]))
    measured = GATES.last + 0.4 * share * DIRECTION + (0.25 + beside) * ACROSS
    assert passed(measured, way) == accepted


@pytest.mark.parametrize(("beyond", "accepted"), [(-NEAR, True), (NEAR, False)])
@pytest.mark.parametrize("ahead", [True, False])
def test_beyond_the_ends_of_the_line_the_distance_from_them_counts(
    beyond: float, *, ahead: bool, accepted: bool
):
    way = GATES._replace(expected=GATES.last + 0.4 * DIRECTION, reach=np.array([2.0]))
    along = 0.4 + 0.25 + beyond if ahead else -0.4 - 0.25 - beyond
    assert passed(GATES.last + along * DIRECTION, way) == accepted


@pytest.mark.parametrize("rebound", [0.0, 0.5])
@pytest.mark.parametrize("period", [0.01, 0.1])
def test_a_vehicle_that_falls_to_the_ground_is_followed_at_any_rate(period: float, rebound: float):
    """From 1 m at 1.5 m/s, stopped or thrown back within a tick and falling again, as at a hard landing."""
    made = PositionTracks(TrackParams(8.0, 4.0, 0.04, 1e-3, 8.0, 0.35, 0.06, 4.0), 1)
    for k in range(round(1.5 / period)):
        t = k * period
        since = t - 1.0 / 1.5
        height = max(-1.5 * since, since * (1.5 * rebound - 0.5 * GRAVITY * since), 0.0)
        tracked = made.update(t, np.array([[0.0, 0.0, height]]))
        assert tracked.accepted[0]
        assert abs(tracked.pos[0, 2] - height) < 0.01


def test_no_sample_of_a_lost_track_passes_and_none_that_is_nan():
    assert not passed(sample(0.0), LOST)
    assert not passed(np.array([[0.0, np.nan, 1.0]]), GATES)


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize("axis", range(3))
def test_a_coordinate_outside_the_room_is_no_number(axis: int, side: float):
    for beyond, inside in ((0.0, True), (NEAR, False)):
        place = np.zeros((1, 3))
        place[0, axis] = side * (8.0 + beyond)
        assert np.isfinite(screen(place, FRESH, GATES)[0]).all() == inside


@pytest.mark.parametrize("moved", [0.0, 0.4, 1.5])
@pytest.mark.parametrize(("step", "moves"), [(0.99, False), (1.01, True)])
def test_a_repeated_pose_is_stale_if_the_vehicle_moves_or_the_pose_is_rejected(
    step: float, moved: float, *, moves: bool
):
    before, now = (np.array([[0.0, part * REPEAT_STEP, 0.0]]) for part in (moved, step - moved))
    ahead = GATES._replace(moved=before, expected=GATES.last + now)
    samples, accepted, frozen = screen(GATES.last, REPEATED, ahead)
    assert not frozen.any()
    noisy = screen(GATES.last, REPEATED, ahead._replace(varies=np.array([True])))
    assert np.isnan(noisy[0]).all()
    assert noisy[2].tolist() == [True]
    assert np.isnan(samples).all() == moves
    assert accepted.tolist() == [not moves]
    far = GATES.last + np.array([0.3, 0.0, 0.0])
    assert np.isnan(screen(far, REPEATED, ahead)[0]).all()
    assert np.isfinite(screen(far, FRESH, ahead)[0]).all()
    assert np.isfinite(screen(far, REPEATED, LOST)[0]).all()


def random_tracks() -> MotionEstimate:
    rng = np.random.default_rng(3)
    root = rng.normal(size=(4, 3, 3))
    return MotionEstimate(rng.normal(size=(4, 3, 3)), root @ root.transpose(0, 2, 1))


def test_a_prediction_is_that_of_the_motion_model():
    """x- = F x and P- = F P F^T + Q with the matrices of the module."""
    tracks, tau, q = random_tracks(), 0.03, 64.0
    F = np.array([[1.0, tau, tau**2 / 2], [0.0, 1.0, tau], [0.0, 0.0, 1.0]])
    Q = q * np.array(
        [
            [tau**5 / 20, tau**4 / 8, tau**3 / 6],
            [tau**4 / 8, tau**3 / 3, tau**2 / 2],
            [tau**3 / 6, tau**2 / 2, tau],
        ]
    )
    ahead = kalman_filter.predict(tracks, np.full(4, tau), q)
    np.testing.assert_allclose(ahead.state, F @ tracks.state, rtol=0.0, atol=1e-14)
    np.testing.assert_allclose(ahead.cov, F @ tracks.cov @ F.T + Q, rtol=0.0, atol=1e-14)


def test_two_predictions_are_one_over_the_sum_of_their_times():
    """F(a + b) = F(b) F(a) and Q(a + b) = F(b) Q(a) F(b)^T + Q(b), within the acceleration's horizon."""
    first, second = np.array([0.01, 0.02, 0.0, 0.05]), np.array([0.03, 0.03, 0.05, 0.0])
    tracks = random_tracks()
    once = kalman_filter.predict(tracks, first + second, 64.0)
    twice = kalman_filter.predict(kalman_filter.predict(tracks, first, 64.0), second, 64.0)
    for one, other in zip(once, twice, strict=True):
        np.testing.assert_allclose(one, other, rtol=0.0, atol=1e-13)  # numbers of order 1 to 10


def test_beyond_the_horizon_a_track_moves_on_at_constant_velocity():
    tracks = random_tracks()
    horizon, later = np.full(4, kalman_filter.ACC_HORIZON), np.full(4, kalman_filter.ACC_HORIZON + 0.25)
    near, far = (kalman_filter.predict(tracks, elapsed, 64.0).state for elapsed in (horizon, later))
    np.testing.assert_array_equal(far[:, 1], near[:, 1])
    gained = kalman_filter.ACC_HORIZON * tracks.state[:, 2]
    np.testing.assert_allclose(far[:, 0] - near[:, 0], 0.25 * (tracks.state[:, 1] + gained), atol=1e-14)


def test_a_correction_adds_the_information_of_the_sample():
    """P^-1 = P-^-1 + H^T H / sigma^2, and P^-1 x = P-^-1 x- + H^T r / sigma^2 with H = (1 0 0)."""
    tracks = random_tracks()
    measured, noise_var = np.arange(12.0).reshape(4, 3), 0.04
    better = kalman_filter.correct(tracks, measured, kalman_filter.gain(tracks, noise_var), noise_var)
    before, after = np.linalg.inv(tracks.cov), np.linalg.inv(better.cov)
    gained = np.zeros((3, 3))
    gained[0, 0] = 1.0 / noise_var
    np.testing.assert_allclose(after, before + gained, rtol=1e-9, atol=1e-9)  # condition number up to 1e3
    right = before @ tracks.state
    right[:, 0] += measured / noise_var
    np.testing.assert_allclose(after @ better.state, right, rtol=1e-9, atol=1e-8)


def test_a_sample_without_noise_is_the_position_to_the_last_bit():
    tracks = random_tracks()
    measured = np.arange(12.0).reshape(4, 3) / 7.0
    better = kalman_filter.correct(tracks, measured, kalman_filter.gain(tracks, 0.0), 0.0)
    assert np.array_equal(better.state[:, 0], measured)


def test_a_track_without_samples_has_no_gain_where_positions_have_no_noise():
    """The plain form warned of 0 / 0 in every tick, in each row of a table that no vehicle uses yet."""
    unused = kalman_filter.MotionEstimate(np.zeros((2, 3, 3)), np.zeros((2, 3, 3)))
    with np.errstate(all="raise"):
        K = kalman_filter.gain.py_func(unused, 0.0)
    assert np.isnan(K).all()
    np.testing.assert_array_equal(kalman_filter.gain(unused, 0.0), K)


def settling(samples: int, period: float = 0.01) -> tuple[PositionTracks, list[Array]]:
    """Return a track at rest after so many samples, and the covariance after each."""
    made = PositionTracks(TrackParams(8.0, 2.0, 0.25, 1e-3, 8.0, 0.35, 0.06, 4.0), 1)
    covs = []
    for k in range(samples):
        made.update(k * period, np.zeros((1, 3)))
        covs.append(made._tracks.cov.copy())
    return made, covs


def test_the_gain_is_steady_once_the_covariance_has_converged_and_then_both_stand_still():
    _, covs = settling(400)
    change = [float((np.abs(b - a) / np.abs(a)).max()) for a, b in pairwise(covs[1:])]
    first = next(k for k, size in enumerate(change) if size <= CONVERGED)
    assert change[first] > 0.0
    assert not any(change[first + 1 :])


def test_a_tick_at_another_time_goes_on_with_the_covariance():
    made, covs = settling(400)
    for late, steady in ((0.5 * SAME_INSTANT, True), (1e-5, False)):
        again = deepcopy(made)
        again.update(400 * 0.01 + late, np.zeros((1, 3)))
        assert np.array_equal(again._tracks.cov, covs[-1]) == steady
    made.update(400 * 0.01, np.full((1, 3), np.nan))
    made.update(401 * 0.01, np.zeros((1, 3)))
    assert not np.array_equal(made._tracks.cov, covs[-1])
