"""The downwash along the horizon is that of the predictor, and ends where that ends."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from resting_signals import resting_state

from q2q_control.mpc.neighbours.constant_velocity import FAR
from q2q_control.mpc.prediction.downwash_horizon import GradientRule, Others, predict_downwash
from q2q_control.mpc.prediction.downwash_horizon_kernel import Tracks, way_in_delay
from q2q_model.downwash.interaction_model import InteractionModel
from q2q_model.downwash.jet import MEASURED_LAW, MOVING_LAW, PAPER_LAW
from q2q_model.downwash.predictor import InteractionPredictor
from q2q_model.geometry.pair_reach import SLACK
from q2q_model.signals.values import Array

STEP, STAGES, PAST = 0.05, 8, 80
TIMES = np.concatenate((0.01 * np.arange(-PAST, 1.0), STEP * np.arange(STAGES + 1.0) + 1e-3))
MIDDLE = 0.5 * (TIMES[PAST + 1] + TIMES[PAST + 2])
"""Of the first stage [s]."""
RULE = GradientRule((0, 1, 2), 10.0)
LAWS = [PAPER_LAW, MEASURED_LAW, MOVING_LAW, replace(MOVING_LAW, absorption=1.5)]


def straight(pos: Array, vel: Array) -> Tracks:
    """Return level vehicles in straight motion that are at `pos` (n, 3) at the middle of the first stage."""
    along = pos + (TIMES - MIDDLE)[:, None, None] * vel
    n = len(pos)
    axis = np.tile([0.0, 0.0, 1.0], (n, STAGES, 1))
    return Tracks(TIMES, along, axis, np.ones((n, STAGES)), PAST + 1)


def predicted(model: InteractionModel, pos: Array, vel: Array) -> Array:
    """Return what the predictor says at the middle of the first stage [m/s^2], (n, 3)."""
    predictor, names = InteractionPredictor(model), tuple(f"cf{k}" for k in range(len(pos)))
    for t in 0.01 * np.arange(-PAST, 1.0):
        found = predictor.update(resting_state(MIDDLE + t, names, pos + t * vel, vel=vel)).acc
    return found


@pytest.mark.parametrize("model", LAWS)
@pytest.mark.parametrize("n", [2, 4, 10])  # all pairs, all pairs, the sweep over x
def test_the_first_stage_has_the_downwash_of_the_predictor(model: InteractionModel, n: int):
    rng, largest = np.random.default_rng(n), 0.0
    for _ in range(4):
        pos = rng.uniform([-0.2, -0.2, 0.0], [0.2, 0.2, 1.1 * model.reach.vertical], (n, 3))
        vel = rng.uniform(-1.5, 1.5, (n, 3))
        found = predict_downwash(model, straight(pos, vel), RULE).eta[:, 0]
        expected = predicted(model, pos, vel)
        # pairs whose downwash stays below 1e-4 m/s^2 are dropped
        np.testing.assert_allclose(found, expected, atol=1e-4 * n)
        largest = max(largest, float(np.abs(expected).max()))
    assert largest > 0.1


@settings(deadline=None, max_examples=25)  # the first call compiles
@given(st.sampled_from(LAWS), st.floats(0.3, 2.0), st.floats(-1.5, 1.5), st.floats(0.0, 5.0))
def test_a_pair_does_not_depend_on_the_speed_of_a_third_vehicle(
    model: InteractionModel, gap: float, own: float, speed: float
) -> None:
    pos, vel = np.array([[0.0, 0.0, 0.0], [0.05, 0.0, gap], [50.0, 0.0, 1.0]]), np.zeros((3, 3))
    vel[1] = [own, 0.0, 0.5 * own]
    found = []
    for third in (0.0, speed):
        vel[2] = third
        found.append(predict_downwash(model, straight(pos, vel), RULE))
    np.testing.assert_array_equal(found[1].eta[:2], found[0].eta[:2])
    np.testing.assert_array_equal(found[1].gradient, found[0].gradient)


def test_a_pair_ends_at_each_stage_by_itself():
    pos, vel = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1.1]]), np.array([[0.0] * 3, [0.0, 0.0, 1.0]])
    eta = predict_downwash(MEASURED_LAW, straight(pos, vel), RULE).eta[0, :, 2]
    height = 1.1 + STEP * np.arange(STAGES) - 1.0 * 1.2 / 7.5  # when the air left, at the gap that counts
    assert (eta[height < 1.15] < -1.0).all()
    assert (eta[height > 1.25] == 0.0).all()


@pytest.mark.parametrize("model", [MEASURED_LAW, replace(MEASURED_LAW, absorption=1.5)])
@pytest.mark.parametrize("off", [-5e-4, 5e-4])  # less than the step of the differences
def test_the_end_of_a_law_is_no_slope_of_it(model: InteractionModel, off: float):
    pos = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, MEASURED_LAW.range + off]])
    found = predict_downwash(model, straight(pos, np.zeros((2, 3))), RULE)
    assert np.abs(found.gradient).max(initial=0.0) < 2.0  # of the law: 0.95 of 1.17 1/s^2


@pytest.mark.parametrize("gap", [0.6, 1.3])
def test_an_uncertain_source_that_is_beside_a_vehicle_may_be_above_it(gap: float):
    aside = 1.2 * MEASURED_LAW.reach.horizontal
    pos, others = (
        np.array([[0.0, 0.0, 0.0], [aside, 0.0, gap]]),
        Others(1, np.array([0.0, aside / np.sqrt(3)])),
    )
    eta = predict_downwash(MEASURED_LAW, straight(pos, np.zeros((2, 3))), RULE, others).eta[0, 0]
    above = MEASURED_LAW.strength * np.exp(-0.95 * (gap - 0.4)) if gap < MEASURED_LAW.range else 0.0
    # of the nine points of the mean, one is above; its weight is 1/6 of 2/3
    assert eta[2] == pytest.approx(-above / 9.0, abs=1e-3)


def test_a_vehicle_that_appears_from_far_away_makes_no_pair():
    tracks = straight(np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 2.0]]), np.zeros((2, 3)))
    tracks.pos[:PAST, 1] = -2.0 * FAR
    found = predict_downwash(MEASURED_LAW, tracks, RULE)
    assert found.i.size == 0
    assert not found.eta.any()


def test_the_way_in_the_delay_is_that_of_the_fastest_steps_and_at_most_all_of_them() -> None:
    vel = np.array([[0.3, 0.4, 0.2], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    tracks = straight(np.zeros((3, 3)), vel)
    tracks.pos[PAST:, 1] += [0.03, 0.04, -0.02]  # measured anew, in one tick
    tracks.pos[:PAST, 2] = FAR
    far = np.full((len(TIMES), 1, 3), np.nan)
    tracks = tracks._replace(pos=np.concatenate((tracks.pos, far), axis=1))
    way = way_in_delay((*tracks,), 0.2, np.array([0.0, 0.0, 0.0, 1.0]))
    expected = [[0.2 * 0.5, 0.2 * 0.2], [0.05, 0.02], [0.0, 0.0], [np.sqrt(6.0), 0.0]]
    np.testing.assert_allclose(way, expected, atol=1.1 * SLACK)
    assert (way >= expected).all()
    np.testing.assert_allclose(way_in_delay((*tracks,), 0.0, np.zeros(4)), SLACK, rtol=1e-12)
