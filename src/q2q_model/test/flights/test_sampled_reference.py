"""References at their own samples: rates of staircases, steps, and gains from each of them."""

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from made_flights import LOOP, Pass, made_flight

from q2q_model.downwash.no_interaction import NoInteraction
from q2q_model.flights.flight import Flight
from q2q_model.flights.reference_remarks import reference_remarks
from q2q_model.flights.sampled_reference import sampled_reference
from q2q_model.identification.gains.altitude_from_flight import altitude_records
from q2q_model.identification.gains.command_gains import GainFit, gains_from_commands
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, GRAVITY

T = np.arange(2000) * 0.01
OMEGA = 2.0 * np.pi * 0.5
UNKNOWN = np.full((len(T), 1, 3), np.nan)


def sine(t: Array) -> tuple[Array, Array, Array]:
    """Return position, velocity and acceleration of one vehicle at times t, (k, 1, 3) each."""
    phase = OMEGA * t[:, None, None] + np.array([0.0, 1.0, 2.0])
    return 0.2 * np.sin(phase), 0.2 * OMEGA * np.cos(phase), -0.2 * OMEGA**2 * np.sin(phase)


@pytest.mark.parametrize("every", [1, 5, 10])
def test_rates_of_a_staircase_are_those_of_the_motion_at_its_samples(every: int) -> None:
    held = np.arange(len(T)) // every * every
    pos, vel, acc = sine(T[held])
    found = sampled_reference(T, pos, UNKNOWN, UNKNOWN)
    rows = np.arange(0, len(T), every)
    inner = rows[(T[rows] > 0.5) & (T[rows] < 19.5)]  # at the ends a cubic has samples on one side only
    assert set(inner) <= set(np.flatnonzero(found.sure[:, 0])) <= set(rows)
    assert np.isnan(np.delete(found.pos, rows, axis=0)).all()
    np.testing.assert_allclose(found.pos[inner], pos[inner], atol=2e-3 * 0.2)
    np.testing.assert_allclose(found.vel[inner], vel[inner], atol=2e-3 * 0.2 * OMEGA)
    np.testing.assert_allclose(
        found.acc[inner], acc[inner], atol=4e-2 * 0.2 * OMEGA**2
    )  # (OMEGA width)^2 / 10
    assert found.fitted.all()
    assert not found.uneven.any()


def test_long_recordings_at_high_rates_are_fitted_in_little_memory() -> None:
    t = np.arange(30_000) / 300.0
    pos, vel, _ = sine(t)
    unknown = np.full_like(pos, np.nan)
    tracemalloc.start()
    try:
        found = sampled_reference(t, pos, unknown, unknown)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 100e6  # [B]; 5e4 B for every sample, if the windows of all are there at once
    inner = slice(100, -100)
    assert found.sure.all()
    np.testing.assert_allclose(found.vel[inner], vel[inner], atol=2e-3 * 0.2 * OMEGA)


def test_a_fit_takes_as_many_samples_at_1000_hz_as_at_200_hz() -> None:
    """So that its time grows with the samples, not with the samples times their rate."""
    t = np.arange(10_000) / 1000.0
    pos = sine(t)[0] + 1e-3 * np.random.default_rng(4).standard_normal((len(t), 1, 3))
    dense, sparse = (
        sampled_reference(t[::every], pos[::every], unknown, unknown)
        for every in (1, 5)
        for unknown in [np.full_like(pos[::every], np.nan)]
    )
    np.testing.assert_allclose(dense.pos[::5], sparse.pos, atol=1e-12)
    np.testing.assert_allclose(dense.vel[::5], sparse.vel, atol=1e-10)
    np.testing.assert_allclose(dense.acc[::5], sparse.acc, atol=1e-8)


def test_recorded_rates_are_kept_as_they_are() -> None:
    held = np.arange(len(T)) // 5 * 5
    given = sine(T[held])
    found = sampled_reference(T, *given)
    for kept, one in zip((found.pos, found.vel, found.acc), given, strict=True):
        np.testing.assert_array_equal(kept[::5], one[::5])
    assert np.count_nonzero(found.sure) == len(T) / 5
    assert not found.fitted.any()


@pytest.mark.parametrize("lost", [slice(1000, 1001), slice(1000, 1010)])
def test_a_component_that_is_no_number_is_no_sample(lost: slice) -> None:
    given, vel, _ = sine(T)
    pos = given.copy()
    pos[lost, 0, 2] = np.nan
    found = sampled_reference(T, pos, UNKNOWN, UNKNOWN)
    assert not found.sure[lost].any()
    near = found.sure[:, 0] & (np.abs(T - 10.0) < 1.0)
    assert np.count_nonzero(near) >= 170
    np.testing.assert_allclose(found.pos[near], given[near], atol=2e-3 * 0.2)
    np.testing.assert_allclose(found.vel[near], vel[near], atol=2e-2 * 0.2 * OMEGA)  # a side is lost


def test_altitudes_alone_are_a_reference() -> None:
    given, vel, _ = sine(T)
    pos = np.where([False, False, True], given, np.nan)
    found = sampled_reference(T, pos, UNKNOWN, UNKNOWN)
    assert found.sure.all()
    np.testing.assert_allclose(found.vel[50:-50, 0, 2], vel[50:-50, 0, 2], atol=2e-3 * 0.2 * OMEGA)
    assert np.isnan(found.vel[..., :2]).all()


def test_only_what_lacks_is_fitted_and_told() -> None:
    pos, vel, acc = sine(T)
    found = sampled_reference(T, pos, vel, UNKNOWN)
    np.testing.assert_array_equal(found.pos, pos)
    np.testing.assert_array_equal(found.vel, vel)
    np.testing.assert_allclose(found.acc[50:-50], acc[50:-50], atol=4e-2 * 0.2 * OMEGA**2)
    assert found.fitted.tolist() == [[False, True]]
    assert reference_remarks("made", ("cf1",), [found])[0].startswith(
        "made: references of cf1 have no acceleration: it is fitted to their positions, even for"
    )


def test_a_single_rate_that_lacks_is_fitted_without_a_remark() -> None:
    pos, vel, acc = sine(T)
    some = acc.copy()
    some[1000] = np.nan
    found = sampled_reference(T, pos, vel, some)
    np.testing.assert_array_equal(np.delete(found.acc, 1000, axis=0), np.delete(acc, 1000, axis=0))
    np.testing.assert_allclose(found.acc[1000], acc[1000], atol=4e-2 * 0.2 * OMEGA**2)
    assert found.sure.all()
    assert reference_remarks("made", ("cf1",), [found]) == []


def test_goals_and_late_stamps_are_told() -> None:
    goals = sine(np.floor(T))[0]
    assert sampled_reference(T, goals, UNKNOWN, UNKNOWN).goals.all()
    late = np.random.default_rng(3).integers(0, 3, len(T) // 5) + np.arange(0, len(T), 5)
    last = late[np.searchsorted(late, np.arange(len(T)), side="right").clip(1) - 1]
    found = sampled_reference(T, sine(T[last])[0], UNKNOWN, UNKNOWN)
    assert found.uneven.all()
    assert not found.goals.any()


def flown(*, with_rates: bool = True) -> Flight:
    """Return a flight along a moving reference by LOOP, whose controller may have no rates of it."""
    flight = made_flight(Pass(law=NoInteraction(), start=0.2, seconds=30.0, noise=1e-4))
    phase = OMEGA * flight.t[:, None] + np.array([0.0, 1.0])
    ref = flight.ref_pos.copy()
    ref[..., 2] += 0.2 * np.sin(phase)
    vel, acc = np.zeros_like(ref), np.zeros_like(ref)
    vel[..., 2], acc[..., 2] = 0.2 * OMEGA * np.cos(phase), -0.2 * OMEGA**2 * np.sin(phase)
    pos, rate = ref + flight.pos - flight.ref_pos, vel + flight.vel - flight.ref_vel
    given_vel, given_acc = (vel, acc) if with_rates else (0.0 * vel, 0.0 * acc)
    wanted = given_acc + LOOP.k_p * (ref - pos) + LOOP.k_d * (given_vel - rate)
    thrust = CRAZYFLIE_2_0.mass * (GRAVITY + wanted[..., 2])
    return replace(
        flight, mocap_pos=pos, pos=pos, vel=rate, ref_pos=ref, ref_vel=vel, ref_acc=acc, thrust=thrust
    )


def gains(flight: Flight) -> tuple[GainFit, list[str]]:
    """Return the gains of a flight from its commands, and what is told of its references."""
    records, remarks = altitude_records(flight, CRAZYFLIE_2_0)
    return gains_from_commands(records), remarks


def held(flight: Flight, every: int) -> Flight:
    """Return a flight whose references are recorded at every `every`-th tick, and held."""
    row = np.arange(len(flight.t)) // every * every
    return replace(
        flight, ref_pos=flight.ref_pos[row], ref_vel=flight.ref_vel[row], ref_acc=flight.ref_acc[row]
    )


def without_rates(flight: Flight) -> Flight:
    """Return a flight whose references have positions only."""
    unknown = np.full_like(flight.ref_pos, np.nan)
    return replace(flight, ref_vel=unknown, ref_acc=unknown)


@pytest.mark.parametrize("every", [1, 2, 5, 10])
@pytest.mark.parametrize("with_rates", [True, False])
def test_gains_are_those_that_flew_however_rare_references_are(every: int, with_rates: bool) -> None:
    """Also if the controller has none of the rates, as the firmware that is sent positions."""
    fit, remarks = gains(without_rates(held(flown(with_rates=with_rates), every)))
    assert fit.k_p.value == pytest.approx(LOOP.k_p, rel=1e-2)
    assert fit.k_d.value == pytest.approx(LOOP.k_d, rel=1e-2)
    assert fit.of_rates == pytest.approx((0.0, 0.0) if with_rates else (-LOOP.k_d, -1.0), abs=0.05)
    assert len(remarks) == 1
    assert "references of cf1, cf2 have no velocity and acceleration" in remarks[0]


def test_gains_from_full_states_at_20_hz_are_exact() -> None:
    fit, remarks = gains(held(flown(), 5))
    assert fit.k_p.value == pytest.approx(LOOP.k_p, rel=1e-4)
    assert fit.k_d.value == pytest.approx(LOOP.k_d, rel=1e-4)
    assert remarks == []


def test_references_of_pieces_that_are_left_out_are_not_told() -> None:
    """Before a hole of half a second are 1.8 s without rates: too short a piece to be used."""
    flight, lost = flown(), slice(180, 230)
    vel, pos = flight.ref_vel.copy(), flight.pos.copy()
    vel[: lost.start], pos[lost] = np.nan, np.nan
    fit, remarks = gains(replace(flight, pos=pos, mocap_pos=pos, ref_vel=vel))
    assert [remark.partition(":")[0] for remark in remarks] == ["pass"]
    assert "hole of 0.5 s" in remarks[0]
    assert fit.k_p.value == pytest.approx(LOOP.k_p, rel=1e-4)
