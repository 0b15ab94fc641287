"""Gains from trajectories alone: exact without a lag, with an offset where there is one."""

from dataclasses import replace

import numpy as np
import pytest
from made_flights import CALM, LOOP, PLAIN, made_flight, record_of

from q2q_model.flights.flight import of_vehicle
from q2q_model.identification.gains.altitude_from_flight import altitude_record
from q2q_model.identification.gains.altitude_record import AltitudeRecord
from q2q_model.identification.gains.impulse_response import free_response
from q2q_model.identification.gains.trajectory_gains import (
    gains_by_powell,
    gains_from_trajectories,
    is_better,
)
from q2q_model.vehicle.altitude_loop import AltitudeLoop
from q2q_model.vehicle.constants import CRAZYFLIE_2_0


def test_trajectories_alone_give_the_gains_of_a_loop_without_lag() -> None:
    record = record_of(replace(CALM, loop=PLAIN, noise=1e-5))
    fit = gains_from_trajectories([record])
    found = dict(fit.intervals)
    assert found["k_p"].value == pytest.approx(0.81, rel=2e-3)  # the physics steps by 2 ms: order K_d dt
    assert found["k_d"].value == pytest.approx(0.43, rel=5e-3)


def test_gains_that_a_flight_does_not_show_have_intervals_that_say_so() -> None:
    """Both vehicles stay where they should be: no gains are better than any others."""
    still = replace(CALM, start=0.0, noise=0.0)
    found = dict(
        gains_from_trajectories([record_of(still), record_of(replace(still, name="again"))]).intervals
    )
    for name, flown in (("k_p", LOOP.k_p), ("k_d", LOOP.k_d)):
        assert found[name].low <= flown <= found[name].high
        assert not found[name].is_positive


def test_a_lag_hides_in_the_damping_that_trajectories_show() -> None:
    fit = gains_from_trajectories([record_of(CALM)])
    assert fit.loop.k_d == pytest.approx(LOOP.k_d - LOOP.k_p * LOOP.lag, rel=0.05)  # next order: K_d^2 T


def test_powell_through_a_solver_finds_the_same_gains_less_exactly() -> None:
    record = record_of(replace(CALM, loop=PLAIN, seconds=12.0, noise=1e-5))
    powell, exact = gains_by_powell([record]).loop, gains_from_trajectories([record]).loop
    assert powell.k_p == pytest.approx(exact.k_p, rel=0.03)
    assert powell.k_d == pytest.approx(exact.k_d, rel=0.03)  # solve_ivp's tolerance moves K_d by 0.007


def test_an_offset_is_found_where_there_is_one_and_only_there() -> None:
    with_one = [record_of(replace(CALM, loop=AltitudeLoop(0.81, 0.43, offset=0.1)))]
    without = [record_of(replace(CALM, loop=PLAIN))]
    more, less = (gains_from_trajectories(with_one, options) for options in (("offset",), ()))
    assert is_better(more, less)
    assert more.loop.offset == pytest.approx(0.1, rel=0.01)
    assert not is_better(gains_from_trajectories(without, ("offset",)), gains_from_trajectories(without))


def settling(seconds: float, rng: np.random.Generator) -> AltitudeRecord:
    """Return a vehicle that settles from some 10 cm, at 50 Hz, with noise of 2 mm and without an offset."""
    t, loop = np.arange(0.0, seconds, 0.02), AltitudeLoop(k_p=4.0, k_d=2.5)
    start = np.array([[0.1], [0.05]]) * rng.standard_normal((2, 1))
    error = free_response(loop, 0.02, start, np.zeros((t.size, 1)))
    error[1:] += 0.002 * rng.standard_normal((t.size - 1, 1))
    pos, vel, still, ref = (np.zeros((t.size, 1, 3)) for _ in range(4))
    pos[..., 2], vel[0, :, 2], ref[..., 0] = 1.0 + error, start[1], 1.0
    unknown = np.full((t.size, 1), np.nan)
    return AltitudeRecord(
        "settling", ("a",), 0.02, t, pos, vel, still, ref, unknown, unknown, 0.0 * error, 0, t.size
    )


def test_a_short_record_weighs_by_its_rows_in_the_test_of_an_offset() -> None:
    """Six offsets that fit noise in 2.5 s each do not count as much as 30 s."""
    for seed in (0, 10):
        rng = np.random.default_rng(seed)
        records = [settling(seconds, rng) for seconds in (30.0, 2.5, 2.5, 2.5, 2.5, 2.5)]
        plain, shifted = gains_from_trajectories(records), gains_from_trajectories(records, ("offset",))
        rows = np.array([record.t.size for record in records])
        assert plain.rms**2 * rows.sum() == pytest.approx(np.concatenate(plain.mse) @ rows, rel=1e-9)
        assert not is_better(shifted, plain)


def test_gains_come_out_though_every_flight_has_an_offset_of_its_own() -> None:
    loop = AltitudeLoop(8.0, 5.0)
    records = [
        record_of(replace(CALM, name=f"offset {offset}", seconds=20.0, loop=replace(loop, offset=offset)))
        for offset in (0.6, -0.4, 0.2)
    ]
    plain, shifted = gains_from_trajectories(records), gains_from_trajectories(records, ("offset",))
    assert abs(plain.loop.k_p - 8.0) > 2.0
    assert is_better(shifted, plain)
    assert shifted.loop.k_p == pytest.approx(8.0, rel=0.02)
    assert shifted.loop.k_d == pytest.approx(5.0, rel=0.02)
    assert shifted.loop.offset == pytest.approx((0.6 - 0.4 + 0.2) / 3.0, rel=0.02)


def test_flights_of_one_and_of_two_vehicles_give_gains_together() -> None:
    both = replace(CALM, loop=PLAIN, noise=1e-5)
    alone = altitude_record(of_vehicle(made_flight(both), "cf1"), CRAZYFLIE_2_0)
    fit = gains_from_trajectories([record_of(both), alone])
    assert [one.shape for one in fit.mse] == [(2,), (1,)]
    assert fit.loop.k_p == pytest.approx(0.81, rel=2e-3)
