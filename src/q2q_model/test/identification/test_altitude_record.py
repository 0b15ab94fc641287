"""Altitudes of a recorded flight: mended over short holes, cut at long ones, or refused."""

from dataclasses import fields, replace

import numpy as np
import pytest
from made_flights import CALM, LOOP, PASSES, made_flight, record_of, without

from q2q_model.flights.flight import Flight
from q2q_model.identification.gains.altitude_from_flight import altitude_record, altitude_records
from q2q_model.identification.gains.command_gains import gains_from_commands
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import CRAZYFLIE_2_0


@pytest.mark.parametrize("filtered", [np.nan, 1e3])
@pytest.mark.parametrize("on_the_ground", [0, 50])
def test_positions_in_millimetres_are_named(filtered: float, on_the_ground: int) -> None:
    flight = made_flight(CALM)
    mocap, pos = 1e3 * flight.mocap_pos, filtered * flight.pos
    mocap[:on_the_ground], pos[:on_the_ground] = 0.0, 0.0 * filtered
    with pytest.raises(ValueError, match=r"x, y, z of \w+ in .* reach .*: check that they are in metres"):
        altitude_record(replace(flight, mocap_pos=mocap, pos=pos), CRAZYFLIE_2_0)


def test_holes_and_outliers_are_mended_and_counted() -> None:
    flight = made_flight(replace(CALM, noise=0.0))
    pos = flight.mocap_pos.copy()
    pos[500, 0] += [0.0, 0.0, 1.0]
    pos[700:720, 1] = np.nan
    unfiltered = replace(flight, mocap_pos=pos, pos=np.full_like(pos, np.nan), vel=np.full_like(pos, np.nan))
    record = altitude_record(unfiltered, CRAZYFLIE_2_0)
    assert record.outliers == 1
    assert record.samples == 2 * record.t.size - 20
    np.testing.assert_allclose(record.pos, flight.true_pos, atol=1e-4)  # a line over 0.2 s of a slow swing


def test_nothing_is_inferred_across_a_hole() -> None:
    flight = made_flight(CALM)
    whole, holed = record_of(CALM), without(flight, slice(1000, 1100), slice(1150, 1200), slice(2000, 2020))
    found, remarks = altitude_records(holed, CRAZYFLIE_2_0)
    assert len(remarks) == 1
    assert remarks[0].startswith("pass: 2 holes, the longest a hole of 1.0 s at t = 9.99 s, or a jump")
    assert remarks[0].endswith("; without 1 piece shorter than 2 s")
    assert [one.t.size for one in found] == [1000, 1800]  # 0.2 s without a tick are interpolated
    for one, first in zip(found, (0, 1200), strict=True):
        rows = slice(first, first + one.t.size)
        np.testing.assert_allclose(one.t, flight.t[rows], atol=1e-9)
        np.testing.assert_allclose(one.pos, whole.pos[rows], atol=1e-3)  # noise of 0.1 mm, a line over 0.2 s
        np.testing.assert_allclose(one.start[0], whole.deviation[first], atol=1e-9)
        ticks = np.isin(np.arange(3000)[rows], np.arange(2000, 2020), invert=True)
        np.testing.assert_allclose(one.commanded_acc[ticks], whole.commanded_acc[rows][ticks], atol=1e-9)
    with pytest.raises(ValueError, match=r"never last for 2\.0 s together"):
        altitude_records(without(flight, *(slice(k, k + 50) for k in range(100, 3000, 200))), CRAZYFLIE_2_0)


def test_two_flights_in_one_bag_are_two_records() -> None:
    first, second = made_flight(CALM), made_flight(PASSES[0])
    joined = {
        field.name: np.concatenate([getattr(first, field.name), getattr(second, field.name)])
        for field in fields(Flight)
        if isinstance(getattr(first, field.name), np.ndarray)
    }
    both = replace(first, **joined | {"t": np.concatenate([first.t, second.t + 100.0])})
    found, remarks = altitude_records(both, CRAZYFLIE_2_0)
    assert "hole of 70.0 s at t = 29.99 s" in remarks[0]
    for one, alone in zip(found, (record_of(CALM), record_of(PASSES[0])), strict=True):
        np.testing.assert_allclose(one.deviation, alone.deviation, atol=1e-9)
        np.testing.assert_allclose(one.commanded_acc, alone.commanded_acc, atol=1e-9)
    fit = gains_from_commands(found)
    assert fit.k_p.value == pytest.approx(LOOP.k_p, rel=1e-3)


def test_a_vehicle_out_of_sight_is_not_made_up() -> None:
    flight = made_flight(CALM)
    pos = np.where(np.isin(np.arange(flight.t.size), np.arange(900, 1000))[:, None, None], np.nan, flight.pos)
    pos[:, 0] = flight.pos[:, 0]
    found, remarks = altitude_records(replace(flight, pos=pos, mocap_pos=pos), CRAZYFLIE_2_0)
    assert "hole of 1.0 s at t = 8.99 s" in remarks[0]
    assert [one.t.size for one in found] == [900, 2000]


def with_third(flight: Flight, place: Array) -> Flight:
    """Return a flight with a third vehicle of which only positions (T, 3) were recorded."""
    arrays = {field.name: getattr(flight, field.name) for field in fields(Flight)}
    unknown = {k: np.full_like(v[:, :1], np.nan) for k, v in arrays.items() if np.ndim(v) > 1}
    third = unknown | {"pos": place[:, None], "mocap_pos": place[:, None]}
    joined = {k: np.concatenate([arrays[k], one], axis=1) for k, one in third.items()}
    return replace(flight, names=(*flight.names, "spare"), **joined)


def test_a_vehicle_that_only_stands_there_is_left_out_and_named() -> None:
    flight = made_flight(CALM)
    place = np.tile([3.0, 3.0, 0.02], (flight.t.size, 1))
    found, remarks = altitude_records(with_third(flight, place), CRAZYFLIE_2_0)
    assert remarks == ["pass: spare never flew: left out of the gains"]
    np.testing.assert_array_equal(found[0].pos, record_of(CALM).pos)
    place[1000:1100, 2] = 0.5
    with pytest.raises(ValueError, match="together: there is no reference of spare; record"):
        altitude_records(with_third(flight, place), CRAZYFLIE_2_0)


def test_a_flight_without_a_reference_says_what_to_record() -> None:
    flight = made_flight(CALM)
    blind = replace(flight, ref_pos=np.full_like(flight.ref_pos, np.nan))
    with pytest.raises(ValueError, match="record the topics mocap"):
        altitude_record(blind, CRAZYFLIE_2_0)
