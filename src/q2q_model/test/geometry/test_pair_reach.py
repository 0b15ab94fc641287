"""A pair's downwash ends at the model's reach, whatever the rest of the swarm does."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_networks import networks
from resting_signals import resting_state

from q2q_model.downwash.interaction_model import InteractionModel, downwash_at_rest, pairs_at_rest
from q2q_model.downwash.jet import MEASURED_LAW, MOVING_LAW, PAPER_LAW
from q2q_model.downwash.level_set import level_set
from q2q_model.downwash.predictor import InteractionPredictor
from q2q_model.geometry.pair_reach import beyond_reach
from q2q_model.identification.push.along_flight import Motion, eta_along
from q2q_model.signals.values import Array, Interference

STACKED = replace(MOVING_LAW, loading=0.6, absorption=1.5, velocity_share=0.6)
LAWS: list[InteractionModel] = [PAPER_LAW, MEASURED_LAW, MOVING_LAW, STACKED, networks()]
DT = 0.01
LEVEL = pairs_at_rest(np.zeros(3))


def online(model: InteractionModel, pos: Array, vel: Array) -> list[Interference]:
    """Return the predictions along positions and velocities (T, n, 3) of level vehicles."""
    predictor, names = InteractionPredictor(model), tuple(f"cf{k}" for k in range(pos.shape[1]))
    return [
        predictor.update(resting_state(DT * k, names, here, vel=there))
        for k, (here, there) in enumerate(zip(pos, vel, strict=True))
    ]


def braking_pair(law: InteractionModel, start: float, slowing: float, gap: float) -> tuple[Array, Array]:
    """Return positions and velocities (60, 2, 3) of one at rest and one that brakes beside or above it."""
    t = DT * np.arange(60.0)[:, None]
    stop = min(start / slowing, 0.59) if slowing > 0.0 else 0.59
    away = start * np.minimum(t, stop) - 0.5 * slowing * np.minimum(t, stop) ** 2
    way = np.array([0.8, 0.0, 0.6])  # aside and up
    pos, vel = np.zeros((60, 2, 3)), np.zeros((60, 2, 3))
    pos[:, 1] = [law.reach.horizontal - 0.3, 0.0, gap] + (away - away[-1]) * way
    vel[:, 1] = np.where(t < stop, start - slowing * t, 0.0) * way
    return pos, vel


@settings(deadline=None, max_examples=30)  # the first call compiles
@given(
    st.sampled_from(LAWS), st.floats(0.3, 2.0), st.floats(0.0, 2.0), st.floats(0.0, 6.0), st.floats(0.0, 5.0)
)
def test_the_downwash_of_a_pair_does_not_depend_on_the_speed_of_a_third_vehicle(
    law: InteractionModel, gap: float, start: float, slowing: float, speed: float
) -> None:
    pos, vel = braking_pair(law, start, slowing, gap)
    found = []
    for third in (0.0, speed):
        far, fast = np.full((60, 1, 3), 50.0), np.full((60, 1, 3), third)
        far[:, 0] += DT * third * np.arange(60.0)[:, None]
        found.append(online(law, np.concatenate((pos, far), 1), np.concatenate((vel, fast), 1)))
    for rest, moving in zip(*found, strict=True):
        np.testing.assert_array_equal(moving.acc[:2], rest.acc[:2])
        np.testing.assert_array_equal(moving.std[:2], rest.std[:2])


@pytest.mark.parametrize("law", [MEASURED_LAW, MOVING_LAW])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_the_height_difference_that_counts_is_that_when_the_air_left(law: InteractionModel, side: float):
    t = DT * np.arange(80.0)
    pos, vel = np.zeros((80, 2, 3)), np.zeros((80, 2, 3))
    pos[:, 1, 2], vel[:, 1, 2] = law.reach.vertical + 0.05 * side + side * (t - t[-1]), side
    now = pos[-1, 1]
    then = now - vel[-1, 1] * law.delay(now[None])[0]
    climbs = side > 0.0
    assert (now[2] > law.reach.vertical, then[2] > law.reach.vertical) == (climbs, not climbs)
    expected = law.acceleration(then, replace(LEVEL, source_vel=vel[-1, 1])) if climbs else np.zeros(3)
    np.testing.assert_allclose(online(law, pos, vel)[-1].acc[0], expected, atol=1e-9)
    assert (abs(expected[2]) > 0.3) == climbs


def test_the_jet_of_a_fast_source_still_meets_a_vehicle_far_behind_where_it_left():
    t = DT * np.arange(80.0)
    pos, vel = np.zeros((80, 2, 3)), np.zeros((80, 2, 3))
    pos[:, 1, 0], pos[:, 1, 2], vel[:, 1, 0] = 3.0 * (t - t[-1]), 1.4, 3.0
    left = 3.0 * MOVING_LAW.delay(pos[-1, 1][None])[0]
    assert left > MOVING_LAW.reach.horizontal
    over = MOVING_LAW.acceleration(np.array([0.0, 0.0, 1.4]), LEVEL)  # carried along, it arrives below
    np.testing.assert_allclose(online(MOVING_LAW, pos, vel)[-1].acc[0], over, rtol=1e-6)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("seed", range(2))
def test_the_predictor_gives_in_flight_what_an_evaluation_of_the_flight_gives(
    law: InteractionModel, seed: int
):
    rng, t = np.random.default_rng(seed), DT * np.arange(150.0)[:, None, None]
    swing, rate = rng.uniform(-0.5, 0.5, (4, 3)), rng.uniform(1.0, 5.0, (4, 3))
    start = rng.uniform([-0.2, -0.2, 0.0], [0.2, 0.2, 2.4], (4, 3))
    pos, vel = start + swing * np.sin(rate * t), swing * rate * np.cos(rate * t)
    axis = np.zeros_like(pos)
    axis[..., 2] = 1.0
    flown = eta_along(law, Motion(t[:, 0, 0], pos, vel, axis))
    predicted = np.stack([one.acc for one in online(law, pos, vel)])
    start_up = 65  # ticks in which the acceleration of a source when its air left it is not known yet
    np.testing.assert_allclose(predicted[start_up:], flown[start_up:], atol=1e-9)
    assert np.abs(flown).max() > 0.1


@pytest.mark.parametrize("law", [PAPER_LAW, MEASURED_LAW, MOVING_LAW, networks()])
def test_at_rest_a_law_ends_where_it_reaches(law: InteractionModel):
    inside = np.array([0.0, 0.0, law.reach.vertical])
    outside = [inside * 1.0001, -inside * 1.0001, np.array([law.reach.horizontal * 1.0001, 0.0, 0.5])]
    np.testing.assert_array_equal(downwash_at_rest(law, inside), law.acceleration(inside, LEVEL))
    np.testing.assert_array_equal(downwash_at_rest(law, np.array(outside)), 0.0)


def test_a_zone_ends_with_the_downwash():
    weak = 0.5  # the law is still 1.17 at its range
    zone = level_set(MEASURED_LAW, weak)
    gaps = np.stack([np.zeros(200), np.zeros(200), np.linspace(0.1, 2.0, 200)], axis=1)
    felt = np.abs(downwash_at_rest(MEASURED_LAW, gaps)[:, 2]) >= weak
    # the distance is accurate to half a step of the table, 0.01 m
    near_edge = np.abs(gaps[:, 2] - MEASURED_LAW.range) < 0.01
    np.testing.assert_array_equal((zone.signed_distance(gaps) < 0.0)[~near_edge], felt[~near_edge])


def test_a_pair_is_in_reach_sideways_by_where_its_source_is_or_was():
    near, far = np.array([0.1, 0.0, 0.5]), np.array([0.4, 0.0, 0.5])
    then, now = np.stack([near, near, far, far]), np.stack([near, far, near, far])
    np.testing.assert_array_equal(beyond_reach(then, now, (0.2, 1.0)), [False, False, False, True])
    assert not beyond_reach(np.full((1, 3), np.nan), far[None], (0.2, 1.0))[0]
