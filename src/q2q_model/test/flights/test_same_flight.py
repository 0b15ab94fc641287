"""Flights that a model or an air was fitted to."""

import os
from collections.abc import Callable
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from made_flights import Pass, made_flight

from q2q_model.flights.duplicates.motion_windows import WINDOWS_MAX, as_text, from_text, motion_windows
from q2q_model.flights.duplicates.same_flight import (
    COPY_IN_FIT,
    IN_FIT,
    fit_remarks,
    flight_digest,
    is_same_flight,
)
from q2q_model.flights.flight import Flight, flight_of_vehicles, of_rows
from q2q_model.recordings.recording_reader import recording_of_table

DATA = Path(os.environ.get("Q2Q_DATA", "../shared/data")) / "neural_swarm"

HOVER = 0.001
"""Noise of the positions of a hovering vehicle [m]."""


def hover(seed: int, seconds: float = 30.0) -> Flight:
    """Return a flight of two vehicles that hover, at positions of their own for each seed."""
    flight = made_flight(Pass(seconds=seconds))
    ticks = flight.t.size
    noise = HOVER * np.random.default_rng(seed).standard_normal((ticks, 2, 3))
    seen = np.array([[0.0, 0.0, 1.0], [0.0, 0.5, 1.0]]) + noise
    return replace(flight, mocap_pos=seen, true_pos=np.full_like(seen, np.nan))


def test_a_flight_is_known_by_its_contents_under_any_name_and_doubted_by_its_name() -> None:
    flight, stranger = hover(0), hover(1)
    files = ["room/pass"], [flight_digest(flight)]
    named = {
        "new": replace(flight, name="new"),
        "pass": replace(stranger, name="pass"),
        "else": replace(stranger, name="else"),
    }
    assert fit_remarks(named.values(), *files) == {"new": COPY_IN_FIT, "pass": IN_FIT}
    assert fit_remarks([replace(flight, name="pass")], files[0], []) == {"pass": IN_FIT}


def test_a_digest_of_an_older_file_is_known_by_its_whole_flight_alone() -> None:
    flight = hover(0)
    old = flight_digest(flight).partition(":")[0]
    assert len(old) == 64
    assert is_same_flight(flight_digest(flight), old)
    assert not is_same_flight(flight_digest(of_rows(flight, slice(5, None))), old)


def _single_precision(flight: Flight) -> Flight:
    return replace(flight, mocap_pos=flight.mocap_pos.astype(np.float32).astype(np.float64))


@pytest.mark.parametrize(
    "changed",
    [
        lambda one: of_rows(one, slice(5, None)),
        lambda one: of_rows(one, slice(1000, 2000)),
        lambda one: replace(one, t=one.t + 0.01),
        lambda one: replace(one, t=2.0 * one.t + 1e6),
        lambda one: replace(one, names=("a", "b")),
        lambda one: flight_of_vehicles(one, ("cf2",)),
        lambda one: flight_of_vehicles(one, ("cf2", "cf1")),
        lambda one: replace(one, mocap_pos=one.mocap_pos + 1.23456789),
        _single_precision,
    ],
    ids=["cut", "a part", "moved in time", "other stamps", "renamed", "one", "order", "moved", "single"],
)
def test_a_changed_copy_of_a_flight_is_the_same_flight(changed: Callable[[Flight], Flight]) -> None:
    flight = hover(0)
    assert is_same_flight(flight_digest(changed(flight)), flight_digest(flight))
    assert not is_same_flight(flight_digest(changed(flight)), flight_digest(hover(1)))


@pytest.mark.skipif(not DATA.is_dir(), reason=f"no recorded flights in {DATA}: set Q2Q_DATA")
def test_recorded_flights_are_known_by_their_parts_and_from_each_other() -> None:
    flights = [recording_of_table(file).flight for file in sorted(DATA.glob("dc21_swap_ss*.parquet"))]
    assert len(flights) == 11
    for one in flights:
        part = of_rows(one, slice(one.t.size // 4, None))
        copy = replace(part, t=part.t - part.t[0], mocap_pos=part.mocap_pos + 0.123456)
        assert is_same_flight(flight_digest(_single_precision(copy)), flight_digest(one))
    assert not any(is_same_flight(*pair) for pair in combinations(map(flight_digest, flights), 2))


def test_parts_that_overlap_are_the_same_flight_and_parts_that_do_not_are_two() -> None:
    flight = hover(0)
    first, middle, last = (of_rows(flight, slice(k, k + 1000)) for k in (0, 500, 2000))
    assert is_same_flight(flight_digest(first), flight_digest(middle))
    assert not is_same_flight(flight_digest(first), flight_digest(last))


def test_rest_and_constant_velocity_are_no_motion_to_know_a_flight_by() -> None:
    t = np.arange(3000) * 0.01
    still = np.zeros((3000, 1, 3))
    assert not motion_windows(still)
    assert not motion_windows(still + 0.7 * t[:, None, None])
    assert not motion_windows(np.full((3000, 1, 3), np.nan))


def test_a_part_of_a_flight_of_an_hour_is_known_by_the_windows_that_are_kept() -> None:
    pos = HOVER * np.random.default_rng(2).standard_normal((360_000, 1, 3))
    hour, part = hover(0), hover(0)
    t = np.linspace(0.0, 3599.99, len(pos))
    hour = replace(hour, t=t, mocap_pos=pos)
    part = replace(part, t=t[100_000:160_000], mocap_pos=pos[100_000:160_000])
    assert [len(one) for one in motion_windows(pos)] == [WINDOWS_MAX]
    assert is_same_flight(flight_digest(hour), flight_digest(part))


def test_windows_are_read_as_they_were_written() -> None:
    windows = motion_windows(hover(0).mocap_pos)
    assert [len(one) > 10 for one in windows] == [True, True]
    assert from_text(as_text(windows)) == windows
    assert from_text("no base64") == ()


def test_windows_of_a_file_that_does_not_part_them_by_vehicle_are_read() -> None:
    flight = hover(0)
    whole, windows, _ = flight_digest(flight).split(":")
    pooled = f"{whole}:{as_text((frozenset().union(*from_text(windows)),))}"
    for one in (flight, of_rows(flight, slice(5, None))):
        assert is_same_flight(flight_digest(one), pooled)
    assert not is_same_flight(flight_digest(hover(1)), pooled)


def test_one_vehicle_that_flies_alike_does_not_make_two_flights_the_same() -> None:
    flight, other = hover(0), hover(1)
    upper = np.array([False, True])[:, None]
    other = replace(other, mocap_pos=np.where(upper, flight.mocap_pos, other.mocap_pos))
    assert not is_same_flight(flight_digest(flight), flight_digest(other))
    assert is_same_flight(flight_digest(flight_of_vehicles(flight, ("cf2",))), flight_digest(other))


def test_simulated_flights_of_the_same_noise_are_the_same_only_if_they_are_equal() -> None:
    flight = hover(0)
    flight = replace(flight, true_pos=flight.mocap_pos)
    sunk = replace(flight, mocap_pos=flight.mocap_pos - np.array([0.0, 0.0, 1e-3]))
    assert is_same_flight(flight_digest(flight), flight_digest(replace(flight, name="copy")))
    assert not is_same_flight(flight_digest(flight), flight_digest(sunk))
