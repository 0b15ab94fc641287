"""A wrong model is put right while flying, and only as far as it may."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from made_flights import LOOP, Pass, made_flight
from resting_signals import level_command, resting_state

from q2q_model.downwash.interaction_model import pairs_at_rest
from q2q_model.downwash.jet import PAPER_LAW
from q2q_model.flights.flight import Flight
from q2q_model.identification.online_refinement import (
    OnlineEstimate,
    OnlineRefinement,
    OnlineRefinementParams,
    PublishedGain,
    limit_reached,
)
from q2q_model.identification.refined_model import scale_downwash
from q2q_model.model_files.model_file import ModelFile, save
from q2q_model.signals.values import SwarmCommand, SwarmImu, SwarmState
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, GRAVITY

FLOWN = Pass(noise=1e-4, speed=0.3)
EAGER = OnlineRefinementParams(prior=0.1)
VEHICLE = replace(CRAZYFLIE_2_0, thrust_lag=LOOP.lag)
Tick = tuple[SwarmState, SwarmCommand, SwarmImu]


def ticks(flight: Flight) -> Iterator[Tick]:
    """Give a made flight tick by tick."""
    zeros, status = np.zeros(2), np.zeros(2, dtype=np.uint8)
    for k, t in enumerate(flight.t):
        when = float(t), flight.names
        yield (
            SwarmState(*when, flight.pos[k], flight.vel[k], flight.quat[k], np.zeros((2, 3)), zeros, status),
            SwarmCommand(*when, flight.thrust[k], zeros, zeros, zeros, status),
            SwarmImu(*when, flight.specific_force_body[k], np.zeros((2, 3))),
        )


def test_a_model_that_is_a_third_too_weak_is_put_right():
    online = OnlineRefinement(scale_downwash(PAPER_LAW, 0.75), VEHICLE, EAGER)
    for tick in ticks(made_flight(FLOWN)):
        estimate = online.update(*tick)
    assert estimate.gain == pytest.approx(1.0 / 0.75, rel=0.03)
    rel_pos = np.array([0.0, 0.0, 0.5])
    true, refined = (
        law.acceleration(rel_pos, pairs_at_rest(rel_pos))[2] for law in (PAPER_LAW, online.refined())
    )
    assert refined == pytest.approx(true, rel=0.03)


def test_a_right_model_stays_as_it_is():
    online = OnlineRefinement(PAPER_LAW, VEHICLE, EAGER)
    gains = [online.update(*tick).gain for tick in ticks(made_flight(FLOWN))]
    assert max(abs(gain - 1.0) for gain in gains) < 0.05


def test_a_constant_of_one_vehicle_is_an_offset_and_no_downwash():
    online = OnlineRefinement(PAPER_LAW, VEHICLE, EAGER)
    for state, command, imu in ticks(made_flight(FLOWN)):
        biased = imu.specific_force_body + np.array([[0.0, 0.0, 0.3], [0.0, 0.0, 0.0]])
        estimate = online.update(state, command, SwarmImu(imu.t, imu.names, biased, imu.ang_vel_body))
    np.testing.assert_allclose(estimate.offset, [0.3, 0.0], atol=0.01)
    assert estimate.gain == pytest.approx(1.0, abs=0.05)


def test_a_broken_sensor_cannot_turn_the_model_around():
    online = OnlineRefinement(PAPER_LAW, VEHICLE, EAGER)
    for state, command, imu in ticks(made_flight(FLOWN)):
        wrong = 50.0 - 5.0 * imu.specific_force_body
        estimate = online.update(state, command, SwarmImu(imu.t, imu.names, wrong, imu.ang_vel_body))
    assert EAGER.gain_min <= estimate.gain <= EAGER.gain_max
    assert (np.abs(estimate.offset) <= EAGER.offset_max).all()


def test_before_any_downwash_the_gain_is_one_and_repeated_stamps_change_nothing():
    online = OnlineRefinement(PAPER_LAW, VEHICLE)
    first = next(ticks(made_flight(FLOWN)))
    once = online.update(*first)
    again = online.update(*first)
    assert once.gain == again.gain == 1.0
    np.testing.assert_array_equal(once.offset, again.offset)


def earlier(tick: Tick, by: float) -> Tick:
    """Return a tick of a clock that was set back."""
    state, command, imu = (replace(one, t=one.t - by) for one in tick)
    return state, command, imu


def test_a_clock_that_restarts_continues_the_refinement_as_if_flown_on():
    """Sums go on; only the thrust before a long pause, of which 24 % are left for a tick, is another."""
    law = scale_downwash(replace(PAPER_LAW, travel_speed=3.0), 0.75)
    flown = list(ticks(made_flight(FLOWN)))
    duration = flown[-1][0].t - flown[0][0].t
    onward, restarted = (
        OnlineRefinement(law, VEHICLE, OnlineRefinementParams(prior=100.0)) for _ in range(2)
    )
    for tick in flown:
        onward.update(*tick)
        half = restarted.update(*tick)
    for tick in flown:
        whole = onward.update(*earlier(tick, -duration - 60.0))  # the air is settled again, too
        again = restarted.update(*tick)
    assert again.t == flown[-1][0].t
    assert again.information == pytest.approx(whole.information, rel=1e-9)
    assert again.gain == pytest.approx(whole.gain, rel=1e-4)
    assert again.information > 1.2 * half.information


def test_a_late_tick_is_no_clock_that_was_set_back():
    online = OnlineRefinement(PAPER_LAW, VEHICLE, EAGER)
    flown = list(ticks(made_flight(FLOWN)))
    for tick in flown[:200]:
        before = online.update(*tick)
    assert online.update(*flown[101]).t == before.t  # 0.98 s late
    assert online.update(*flown[98]).t == flown[98][0].t


def test_a_model_is_published_once_it_has_changed_and_at_once_after_the_clock_was_set_back():
    published = PublishedGain(OnlineRefinementParams(publish_every=1.0, change_min=0.01))
    due = [
        published.update(OnlineEstimate(t, gain, ("a",), np.zeros(1), 1.0, gain))
        for t, gain in (
            (0.0, 1.005),
            (0.1, 1.02),
            (1.0, 1.5),
            (1.1, 1.5),
            (9.0, 1.505),
            (9.1, 1.6),
            (0.0, 1.7),
        )
    ]
    assert due == [False, True, False, True, False, True, True]


def test_missing_sensors_and_nan_leave_a_vehicle_out():
    online = OnlineRefinement(scale_downwash(PAPER_LAW, 0.75), VEHICLE, EAGER)
    for state, command, imu in ticks(made_flight(FLOWN)):
        only_lower = SwarmImu(imu.t, ("cf1",), imu.specific_force_body[:1], imu.ang_vel_body[:1])
        estimate = online.update(state, command, only_lower)
    assert estimate.gain == pytest.approx(1.0 / 0.75, rel=0.05)
    assert estimate.offset[1] == 0.0


def standing(tick: Tick, t: float) -> Tick:
    """Return the tick of vehicles that stand on the ground at t [s], motors off."""
    state, command, imu = (replace(one, t=t) for one in tick)
    on_ground = replace(state, pos=state.pos * [1.0, 1.0, 0.0], vel=0.0 * state.vel)
    felt = np.tile([0.0, 0.0, GRAVITY], (2, 1))
    return on_ground, replace(command, thrust=np.zeros(2)), replace(imu, specific_force_body=felt)


def test_the_ground_before_and_after_a_flight_teaches_nothing_and_nothing_is_forgotten_there():
    """Rotors without lag: those that lag are measured on the ground from 0.3 of the weight on."""
    flown, vehicle = list(ticks(made_flight(FLOWN))), replace(VEHICLE, thrust_lag=0.0)
    begin, end = flown[0][0].t, flown[-1][0].t
    law = scale_downwash(PAPER_LAW, 0.75)
    alone, online = (OnlineRefinement(law, vehicle, EAGER) for _ in range(2))
    before = [standing(flown[0], begin - 5.0 + 0.01 * k) for k in range(500)]
    after = [standing(flown[-1], end + 0.01 * (k + 1)) for k in range(500)]
    for tick in flown:
        expected = alone.update(*tick)
    for tick in (*before, *flown, *after):
        found = online.update(*tick)
    assert found.gain == pytest.approx(expected.gain, rel=1e-6)
    np.testing.assert_allclose(found.offset, expected.offset, rtol=1e-6)


def test_a_vehicle_that_hovers_at_three_fifths_of_the_nominal_weight_teaches_the_same_gain():
    """Its offset is at its limit."""
    light, nominal = (OnlineRefinement(scale_downwash(PAPER_LAW, 0.75), VEHICLE, EAGER) for _ in range(2))
    for state, command, imu in ticks(made_flight(FLOWN)):
        expected = nominal.update(state, command, imu)
        less = command.thrust - 0.4 * VEHICLE.hover_thrust
        found = light.update(state, replace(command, thrust=less), imu)
    assert found.gain == pytest.approx(expected.gain, rel=1e-3)
    np.testing.assert_array_equal(found.offset, light.params.offset_max)


def test_a_gain_at_the_bounds_of_models_leaves_one_that_can_be_saved(tmp_path: Path):
    """Sensors feel 500 times the downwash of a jet whose strength may be 20 m/s^2 at most."""
    online = OnlineRefinement(replace(PAPER_LAW, strength=15.0), VEHICLE, EAGER)
    for state, command, imu in ticks(made_flight(FLOWN)):
        felt = imu.specific_force_body - [0.0, 0.0, GRAVITY]
        strong = replace(imu, specific_force_body=500.0 * felt + [0.0, 0.0, GRAVITY])
        estimate = online.update(state, command, strong)
    assert 1.0 <= estimate.gain == online.params.gain_max <= 20.0 / 15.0
    assert limit_reached(estimate, online.params) == f"gain_max = {online.params.gain_max:g}"
    save(tmp_path / "refined.q2q", ModelFile(online.refined()))


def test_a_model_at_the_bound_of_its_file_is_at_no_limit_until_more_is_felt() -> None:
    online = OnlineRefinement(replace(PAPER_LAW, strength=20.0), VEHICLE, EAGER)
    estimate = online.update(*next(ticks(made_flight(FLOWN))))
    assert estimate.gain == online.params.gain_max == 1.0
    assert limit_reached(estimate, online.params) == ""
    assert limit_reached(replace(estimate, unbounded_gain=1.01), online.params) == "gain_max = 1"
    assert limit_reached(replace(estimate, unbounded_gain=0.49), online.params) == "gain_min = 0.5"


def test_the_prior_holds_the_gain_until_there_is_evidence():
    bold, shy = (
        OnlineRefinement(scale_downwash(PAPER_LAW, 0.75), VEHICLE, OnlineRefinementParams(prior=prior))
        for prior in (0.1, 1000.0)
    )
    for tick in ticks(made_flight(FLOWN)):
        gains = bold.update(*tick).gain, shy.update(*tick).gain
    assert gains[0] > 1.25
    assert 1.0 < gains[1] < 1.05


def test_without_a_prior_a_downwash_that_never_changes_tells_nothing_of_the_gain() -> None:
    """Noise over the rounding of a constant would be any gain, from the smallest to the largest."""
    online, rng = (
        OnlineRefinement(PAPER_LAW, VEHICLE, OnlineRefinementParams(prior=0.0)),
        np.random.default_rng(0),
    )
    state = resting_state(0.0, ("low", "top"), np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 1.5]]))
    command = level_command(0.0, state.names, np.full(2, VEHICLE.hover_thrust))
    for t in np.arange(1, 500) / 100.0:
        force = np.array([[0.0, 0.0, GRAVITY]]) + 0.2 * rng.standard_normal((2, 3))
        imu = SwarmImu(t, state.names, force, np.zeros((2, 3)))
        assert online.update(replace(state, t=t), replace(command, t=t), imu).gain == 1.0
