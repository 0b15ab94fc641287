"""Tests of what is drawn in a room: sizes and correlation, and the same draws for the same seed."""

import math

import numpy as np
import pytest
from room_air_twin import deviation
from room_flights import JET, WHOLE, held, hover, swarm_in

from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import CRAZYFLIE_2_0
from q2q_sim.air.air_terms import ResidualTerm, VehicleTerm, WindTerm
from q2q_sim.air.room_air import TERMS, RoomAir, without_terms
from q2q_sim.air.unit_processes import RESIDUAL, OrnsteinUhlenbeck, PlayedBack
from q2q_sim.air.wake_laws import WakeLaw
from q2q_sim.loop.scenario_air import ambient_of_air
from q2q_sim.plant.body.state_row import ETA_Z
from q2q_sim.plant.swarm import PHYSICS_RATE, Swarm


def test_the_residual_has_its_size_and_correlation() -> None:
    air = RoomAir(jet=JET, residual=ResidualTerm(floor_mps2=0.28, slope=0.1, time_s=0.08))
    places = [place for k in range(100) for place in ((3.0 * k, 0.0, 1.0), (3.0 * k, 0.0, 1.5))]
    swarm = swarm_in(air, places, seed=4)
    pushes = held(swarm, 2 * PHYSICS_RATE)
    mean = swarm_in(RoomAir(jet=JET), places).downwash()[:, 2]
    rest = (pushes - mean)[:, ::2]
    size = deviation(air, mean)[0]
    assert size == pytest.approx(0.28 + 0.1 * -mean[0])
    # 100 processes of 2 s with 0.08 s of correlation: 1250 independent values, 2 % of their deviation
    assert rest.std() == pytest.approx(size, rel=0.08)
    lagged = (rest[40:] * rest[:-40]).mean() / (rest * rest).mean()
    assert lagged == pytest.approx(math.exp(-1.0), abs=0.1)


def test_the_unit_process_goes_on_across_blocks() -> None:
    step, time = 0.002, 0.08
    drawn = OrnsteinUhlenbeck(np.random.default_rng(1), 400, step, time)
    values = np.concatenate([drawn.block(10) for _ in range(20)])
    across = (values[9::10][:-1] * values[10::10]).mean() / (values * values).mean()
    assert across == pytest.approx(math.exp(-step / time), abs=0.02)
    assert values.std() == pytest.approx(1.0, abs=0.05)


def test_a_recording_is_cut_and_pasted_with_its_variance() -> None:
    rng = np.random.default_rng(2)
    recording = np.convolve(rng.standard_normal(6000), np.ones(5) / math.sqrt(5.0), mode="valid")
    played = PlayedBack(rng, 50, 0.002, recording)
    values = np.concatenate([played.block(500) for _ in range(6)])
    # between samples of a process with correlation 0.8 linear interpolation loses 2/3 of 0.2 of the variance
    assert values.std() == pytest.approx(recording.std(), rel=0.1)
    assert np.abs(np.diff(values, axis=0)).max() < 1.0  # no jump where pieces meet
    assert np.ptp(values[:, 0] - values[:, 1]) > 1.0  # vehicles play different pieces


def test_wind_and_offsets_have_their_sizes() -> None:
    own = VehicleTerm(0.2, 0.1, 0.07, headroom=2.0, headroom_per_volt=0.0, discharge_v_per_s=0.0)
    air = RoomAir(wind=WindTerm((0.3, -0.2, 0.1), gust_std_mps2=0.05, gust_time_s=0.2), vehicle=own)
    ambient = ambient_of_air(air, 2000, seed=3)
    pushes = np.array([ambient.drive()[:, :3] for _ in range(50)])
    # 2000 draws: 2 % of a deviation for the mean, 1.6 % for the deviation; five times that
    np.testing.assert_allclose(pushes.mean(axis=(0, 1)), [0.3, -0.2, 0.1 + 0.2], atol=0.012)
    np.testing.assert_allclose(pushes[..., :2].std(axis=(0, 1)), 0.05, rtol=0.08)
    assert ambient.offset.std() == pytest.approx(0.1, rel=0.08)
    assert np.abs(ambient.push(np.zeros((2000, 3))).mean(axis=0)[2] - 0.1) < 0.01  # offsets are no air


def _flown(air: RoomAir, seed: int, pieces: tuple[int, ...]) -> Array:
    swarm = swarm_in(air, [(0.0, 0.0, 0.6), (0.04, 0.0, 1.0), (0.0, 0.05, 1.4)], seed)
    for steps in pieces:
        hover(swarm, steps)
    return swarm.state[:, :ETA_Z]


def test_the_same_seed_gives_the_same_flight_however_it_is_cut() -> None:
    one = _flown(WHOLE, 7, (1200,))
    np.testing.assert_array_equal(one, _flown(WHOLE, 7, (3, 600, 597)))
    assert np.abs(one - _flown(WHOLE, 8, (1200,))).max() > 1e-3


@pytest.mark.parametrize("term", [term for term in TERMS if term != "wind"])
def test_every_term_moves_the_vehicles_and_none_is_left_when_all_are_off(term: str) -> None:
    assert np.abs(_flown(WHOLE, 7, (200,)) - _flown(without_terms(WHOLE, (term,)), 7, (200,))).max() > 1e-7


def test_an_air_without_terms_is_still_air() -> None:
    off = without_terms(WHOLE, TERMS)
    assert off == RoomAir()
    start = np.array([[0.0, 0.0, 0.6, 0.0], [0.04, 0.0, 1.0, 0.0], [0.0, 0.05, 1.4, 0.0]])
    still = Swarm(("a", "b", "c"), CRAZYFLIE_2_0, start, WakeLaw.NONE)
    hover(still, 200)
    np.testing.assert_array_equal(_flown(off, 7, (200,)), still.state[:, :ETA_Z])


def test_switching_a_term_off_leaves_the_draws_of_the_others() -> None:
    swarms = [
        swarm_in(air, [(0.0, 0.0, 1.0)], 5) for air in (WHOLE, without_terms(WHOLE, ("meander", "wind")))
    ]
    units = [swarm.air.room.unit for swarm in swarms if swarm.prepare()]
    np.testing.assert_array_equal(units[0][RESIDUAL], units[1][RESIDUAL])
    assert units[0].std() > 0.5
