"""Neighbours' predictions are followed, age into what is known without them, and widen their downwash."""

import numpy as np
import pytest

from q2q_control.mpc.prediction.downwash_horizon import Others, SlopeRule, predict_downwash
from q2q_control.mpc.prediction.downwash_stages import Tracks
from q2q_control.mpc.prediction.neighbours import (
    FADE,
    TICK,
    TRACKING,
    HeardPredictions,
    PredictedPaths,
    interpolated,
    known_neighbours,
)
from q2q_control.mpc.prediction.surroundings import FAR, Neighbours, at_constant_velocity
from q2q_model.downwash.jet import Jet
from q2q_model.signals.values import Array, SwarmSetpoint, SwarmState, TrackStatus

STEP, STAGES = 0.05, 20
TIMES = 1.0 + STEP * np.arange(STAGES + 1)


def prediction(t: float, slope: float = 1.0, name: str = "cf2") -> PredictedPaths:
    """Return a vehicle that moves along y at `slope` [m/s]; it is at 0 at t + 0.02 [s]."""
    pos = np.zeros((1, STAGES + 1, 3), np.float32)
    pos[0, :, 1] = slope * STEP * np.arange(STAGES + 1)
    return PredictedPaths(t, (name,), t + 0.02, STEP, pos)


def known(x: float = 0.5) -> Neighbours:
    """Return cf2 as known without predictions: at rest at x [m]."""
    path = np.tile([x, 0.0, 0.0], (1, STAGES + 1, 1))
    return Neighbours(("cf2",), path[:, 0], path, np.zeros((1, STAGES, 3)), np.array([TRACKING]))


def test_a_path_is_interpolated_at_the_receivers_stages_and_goes_on_straight_after_its_end() -> None:
    heard = prediction(t=0.97)
    at = interpolated(heard, 0, TIMES + 0.5)
    assert at[:, 1] == pytest.approx(TIMES + 0.5 - 0.99, abs=1e-6)  # float32
    assert TIMES[-1] + 0.5 > heard.start + STAGES * STEP


def test_a_prediction_of_the_tick_before_is_followed_to_the_letter_without_spread() -> None:
    heard = HeardPredictions()
    heard.hear(prediction(t=0.97))
    found = heard.neighbours(0.98, known(), TIMES)
    assert found.path[0] == pytest.approx(interpolated(prediction(t=0.97), 0, TIMES), abs=1e-12)
    assert found.spread[0] == 0.0


def test_of_a_tick_to_come_nothing_is_used_yet() -> None:
    heard = HeardPredictions()
    heard.hear(prediction(t=0.98, slope=9.0))
    heard.hear(prediction(t=0.97))
    assert heard.neighbours(0.98, known(), TIMES).path[0, -1, 1] < 1.1
    assert heard.neighbours(0.99, known(), TIMES).path[0, -1, 1] > 5.0


def test_a_late_prediction_turns_into_what_is_known_and_its_spread_into_the_trackings() -> None:
    heard = HeardPredictions()
    heard.hear(prediction(t=0.5))
    late = TICK + FADE
    found = heard.neighbours(0.5 + late, known(x=1.0), TIMES)
    share = np.exp(-1.0)
    assert found.path[0, :, 0] == pytest.approx(1.0 - share, abs=1e-5)
    assert found.spread[0] == pytest.approx((1.0 - share) * TRACKING, abs=1e-5)
    lost = heard.neighbours(20.0, known(x=1.0), TIMES)
    assert lost.path[0] == pytest.approx(known(x=1.0).path[0], abs=1e-9)


def test_after_a_clock_is_set_back_predictions_count_again() -> None:
    heard = HeardPredictions()
    for t in (50.0, 50.01, 0.5):
        heard.hear(prediction(t))
    assert heard.neighbours(0.51, known(), TIMES).spread[0] == 0.0


@pytest.mark.parametrize("slope", [np.nan, np.inf])
def test_a_prediction_that_is_no_number_is_refused(slope: float) -> None:
    with pytest.raises(ValueError, match="prediction of cf2 is not finite"), np.errstate(invalid="ignore"):
        prediction(0.5, slope)


def test_without_predictions_a_neighbour_is_on_its_reference_and_a_lost_one_far_away() -> None:
    names, flag = ("cf1", "cf2", "cf3", "cf4"), np.zeros(4, np.uint8)
    flag[3] = TrackStatus.LOST
    pos, vel = np.arange(12.0).reshape(4, 3), np.tile([0.0, 1.0, 0.0], (4, 1))
    state = SwarmState(1.0, names, pos, vel, np.tile([0.0, 0.0, 0.0, 1.0], (4, 1)), vel, np.zeros(4), flag)
    two = np.zeros((2, 3))
    given = SwarmSetpoint(1.0, ("cf2", "cf1"), two, two, two, np.zeros(2), np.zeros(2), flag[:2])
    references = np.full((2, STAGES + 1, 9), 7.0)
    found = known_neighbours(at_constant_velocity(state, ("cf1",), TIMES), state, given, references)
    assert found.names == ("cf2", "cf3", "cf4")
    assert (found.path[0] == 7.0).all()
    assert found.path[1, :, 1] == pytest.approx(7.0 + TIMES - 1.0)
    assert np.abs(found.path[2]).min() >= FAR
    assert found.spread.tolist() == [TRACKING, TRACKING, 0.0]


def downwash_below(x: float, spread: float, jet: Jet) -> Array:
    """Return eta_z of a vehicle at rest whose source hovers 0.5 m above it and x [m] aside, (N,)."""
    pos = np.zeros((STAGES + 1, 2, 3))
    pos[:, 1] = x, 0.0, 0.5
    tracks = Tracks(TIMES, pos, np.tile([0.0, 0.0, 1.0], (2, STAGES, 1)), np.ones((2, STAGES)), 0)
    others = Others(1, np.array([0.0, spread]))
    return predict_downwash(jet, tracks, SlopeRule((2,), 100.0), others).eta[0, :, 2]


def test_the_downwash_of_an_uncertain_source_is_its_mean_over_a_normal_distribution() -> None:
    jet = Jet(strength=2.5, reference_gap=0.5, width=0.1, spread=0.0, upper_ratio=0.0)
    sigma = 0.05
    for x in (0.0, 0.05, 0.1, 0.2):
        # two Gaussians convolved in the plane: width^2 grows by sigma^2, the peak falls by their ratio
        wide = 0.1**2 + sigma**2
        exact = -2.5 * 0.1**2 / wide * np.exp(-(x**2) / (2.0 * wide))
        assert downwash_below(x, sigma, jet) == pytest.approx(exact, abs=0.02)
        assert abs(downwash_below(x, 0.0, jet)[0] - exact) > 0.04
