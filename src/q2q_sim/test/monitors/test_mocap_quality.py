"""How well motion capture saw a flight, counted on flights made for it."""

from dataclasses import replace

import numpy as np
import pytest

from q2q_model.flights.flight import Flight
from q2q_sim.loop.closed_loop import FlightOptions, fly
from q2q_sim.monitors.mocap_quality import mocap_quality
from q2q_sim.scenarios import library


@pytest.fixture(scope="module")
def perfect() -> Flight:
    scenario = replace(library.load("table6"), duration=2.0)
    return fly(scenario, FlightOptions(mode="ignoring"))


def test_a_perfect_room_shows_every_vehicle_in_every_frame_at_100_hz(perfect: Flight) -> None:
    quality = mocap_quality(perfect)["cf1"]
    assert quality.rate_hz == pytest.approx(100.0)
    assert quality.seen_share == 1.0
    assert quality.longest_gap_s == pytest.approx(0.01)
    assert quality.rejected == 0


def test_a_hole_and_an_outlier_are_counted_for_the_vehicle_that_has_them(perfect: Flight) -> None:
    mocap = perfect.mocap_pos.copy()
    mocap[50:70, 1] = np.nan
    mocap[100, 1, 2] += 0.5
    quality = mocap_quality(replace(perfect, mocap_pos=mocap))
    assert quality["cf2"].longest_gap_s == pytest.approx(0.21)
    assert quality["cf2"].seen_share == pytest.approx(0.9)
    assert quality["cf2"].rejected == 1
    assert quality["cf1"].rejected == 0


def test_a_vehicle_that_was_never_seen_is_said_to_be_so(perfect: Flight) -> None:
    mocap = np.full_like(perfect.mocap_pos, np.nan)
    quality = mocap_quality(replace(perfect, mocap_pos=mocap))["cf1"]
    assert quality.rate_hz == 0.0
    assert quality.longest_gap_s == float("inf")
