"""The law of recorded vehicles is read from thrust commands, which are the size of the whole force."""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from q2q_model.flights.flight import of_rows
from q2q_model.geometry.rotations import quat_from_euler
from q2q_model.recordings.flight_recording import Recording
from q2q_model.recordings.recording_reader import recording_of_bag, recording_of_table
from q2q_model.trajectory.flatness import flat_state
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, GRAVITY
from q2q_sim.air.wake_laws import WakeLaw
from q2q_sim.experiments.validation.drawn_air import Draw
from q2q_sim.experiments.validation.recorded.recorded_law import ReadFlight, RecordedLaw, feedback, read_law
from q2q_sim.experiments.validation.recorded.tracked_flight import TrackedFlight, flying_grid, tracked_flight
from q2q_sim.experiments.validation.redrawn_flight import redraw_flight
from q2q_sim.plant.disturbance import Disturbance, DisturbanceParams
from q2q_sim.plant.swarm import Swarm

DATA = Path(os.environ.get("Q2Q_DATA", Path(__file__).parents[4].parent / "shared" / "data"))
NEEDS_DATA = pytest.mark.skipif(not DATA.is_dir(), reason=f"real flights are not at {DATA}: set Q2Q_DATA")
DT = 0.01
NAMES = ("cf1", "cf2")
LATE = 11
"""Rows by which the vehicles point late: 0.15 of the thrust lag of 0.07 s, and 2 zeta / w of 60 rad/s."""
LAW = RecordedLaw(
    k_p=np.array([40.0, 40.0, 20.0]),
    k_d=np.array([20.0, 20.0, 10.0]),
    k_i=np.array([0.6, 0.6, 0.6]),
    offset=np.array([[0.0, 0.0, 0.3], [0.0, 0.0, -0.1]]),
    rms=0.0,
)


def agile(seconds: float = 10.0) -> TrackedFlight:
    """Return a flight of two leaning vehicles that command the force of LAW and point along it, late."""
    t = DT * np.arange(round(seconds / DT))[:, None, None]
    axis, vehicle = np.arange(3), np.arange(2)[:, None]
    ref_pos = 0.3 * np.sin((2.0 + 0.7 * axis + 0.3 * vehicle) * t)
    error = 0.02 * np.sin((5.0 + 1.3 * axis - 0.9 * vehicle) * t + axis)
    ref_vel, rate = np.gradient(ref_pos, DT, axis=0), np.gradient(error, DT, axis=0)
    ref_acc = np.gradient(ref_vel, DT, axis=0)
    acc = ref_acc + LAW.offset + feedback(LAW, error, rate, np.cumsum(error, axis=0) * DT)
    pointed = flat_state(acc, np.zeros(acc.shape[:2]))
    everywhere = np.ones(acc.shape[:2], dtype=bool)
    return TrackedFlight(
        name="agile",
        names=NAMES,
        dt=DT,
        pos=ref_pos - error,
        vel=ref_vel - rate,
        quat=quat_from_euler(*(np.roll(angle, LATE, axis=0) for angle in (pointed.roll, pointed.pitch)), 0.0),
        ref_pos=ref_pos,
        ref_vel=ref_vel,
        ref_acc=ref_acc,
        acc=np.full(acc.shape, np.nan),
        thrust=CRAZYFLIE_2_0.mass * pointed.thrust,
        compensated=np.zeros(acc.shape[:2]),
        usable=everywhere,
        exposed=~everywhere,
        free=everywhere,
        scored=np.ones(2, dtype=bool),
        sure=everywhere,
        stepped=~everywhere,
    )


def test_vertical_and_lateral_gains_are_read_from_the_size_of_the_force():
    law = read_law(agile(), CRAZYFLIE_2_0).law
    np.testing.assert_allclose(law.k_p, LAW.k_p, rtol=1e-3)
    np.testing.assert_allclose(law.k_d, LAW.k_d, rtol=1e-3)
    assert law.k_i[2] == pytest.approx(0.6, rel=0.05)
    assert law.rms < 1e-4
    assert law.attitude.frequency == pytest.approx(65.0, abs=10.0)  # a delay is not quite this loop


def test_rows_under_a_wake_do_not_determine_the_attitude_loop():
    flight = agile()
    rows = flight.t < 7.0
    tipped = flight.quat.copy()
    tipped[rows] = np.roll(tipped, 5 - LATE, axis=0)[rows]  # 0.07 s earlier
    clear = np.broadcast_to(~rows[:, None], flight.free.shape)
    without, under, everywhere = (
        read_law(one, CRAZYFLIE_2_0).law.attitude.frequency
        for one in (
            replace(flight, free=clear),
            replace(flight, quat=tipped, free=clear),
            replace(flight, quat=tipped),
        )
    )
    assert under == without
    assert everywhere > without


def test_a_flight_is_redrawn_with_thrusts_of_the_size_of_the_force():
    flight = agile(1.0)

    def make(seed: int, start: np.ndarray) -> Draw:
        still = Disturbance(DisturbanceParams(), 2, DT, seed)
        return Draw(Swarm(NAMES, CRAZYFLIE_2_0, start, WakeLaw.NONE, seed), still)

    drawn = redraw_flight(ReadFlight(flight, LAW), CRAZYFLIE_2_0.mass, make, [0])
    error = flight.ref_pos - drawn.pos[0]
    acc = flight.ref_acc + LAW.offset
    acc = acc + feedback(LAW, error, flight.ref_vel - drawn.vel[0], DT * np.cumsum(error, axis=0))
    size = np.linalg.norm(acc + np.array([0.0, 0.0, GRAVITY]), axis=-1)
    np.testing.assert_allclose(drawn.thrust[0], CRAZYFLIE_2_0.mass * size, rtol=1e-9)


@pytest.mark.parametrize("jitter", [0.0, 3e-3])
def test_times_without_a_recorded_row_are_not_compared(recorded: Recording, jitter: float):
    recording = jittered(recorded, jitter)
    whole, grid = tracked_flight(recording, CRAZYFLIE_2_0), flying_grid(recording.flight)
    begin = grid[np.flatnonzero(whole.exposed[:, 0])[0]]
    t = recording.flight.t
    there = (t < begin - 0.3) | (t > begin + 0.2)
    left = of_rows(recording.flight, there)
    thin, thin_grid = tracked_flight(replace(recording, flight=left), CRAZYFLIE_2_0), flying_grid(left)
    last, first = left.t[left.t < begin][-1], left.t[left.t > begin][0]
    hole = (thin_grid > last + 0.95 * DT) & (thin_grid < first - 0.95 * DT)
    assert 48 <= hole.sum() <= 51
    assert whole.usable[(grid > last) & (grid < first), 0].mean() > 0.9
    for mask in (thin.usable, thin.exposed, thin.free):
        assert not mask[hole].any()
    assert thin.exposed[thin_grid > first].sum() == pytest.approx(whole.exposed[grid > first].sum(), abs=2)


def test_rows_whose_stamps_jitter_are_all_compared(recorded: Recording):
    whole, late = (tracked_flight(jittered(recorded, size), CRAZYFLIE_2_0) for size in (0.0, 3e-3))
    assert whole.usable.all()
    assert late.usable.all()
    assert late.free.mean() == pytest.approx(whole.free.mean(), rel=0.01)


@pytest.mark.parametrize("every", [1, 5])
def test_rates_that_references_lack_are_those_of_their_positions(recorded: Recording, every: int):
    flight, unknown = recorded.flight, np.full_like(recorded.flight.ref_vel, np.nan)
    row = np.arange(len(flight.t)) // every * every
    mapped = replace(flight, ref_pos=flight.ref_pos[row], ref_vel=unknown, ref_acc=unknown)
    found = tracked_flight(replace(recorded, flight=mapped), CRAZYFLIE_2_0)
    whole = tracked_flight(recorded, CRAZYFLIE_2_0)
    inner = slice(100, -100)
    np.testing.assert_allclose(found.ref_pos[inner], whole.ref_pos[inner], atol=1e-3)
    np.testing.assert_allclose(found.ref_vel[inner], whole.ref_vel[inner], atol=0.01)
    np.testing.assert_allclose(found.ref_acc[inner], whole.ref_acc[inner], atol=0.1)


@pytest.fixture(scope="module")
def recorded() -> Recording:
    """Return a recorded flight."""
    return recording_of_bag(Path(__file__).parents[4] / "bags" / "table2_1")


def jittered(recorded: Recording, size: float) -> Recording:
    """Return a flight whose stamps are up to `size` [s] off."""
    t = recorded.flight.t
    noise = np.random.default_rng(0).uniform(-size, size, t.size)
    return replace(recorded, flight=replace(recorded.flight, t=t + noise), log=None)


@NEEDS_DATA
def test_real_vehicles_have_round_gains_the_lateral_ones_twice_the_vertical():
    table = recording_of_table(DATA / "neural_swarm" / "dc21_swap_ss_07.parquet")
    law = read_law(tracked_flight(table, CRAZYFLIE_2_0), CRAZYFLIE_2_0).law
    np.testing.assert_allclose(law.k_p, [20.0, 20.0, 10.0], rtol=0.02)
    np.testing.assert_allclose(law.k_d, [10.0, 10.0, 5.0], rtol=0.02)
    assert law.rms < 0.01
