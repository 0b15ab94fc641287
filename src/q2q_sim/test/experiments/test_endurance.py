"""Growth of what a long flight holds: slopes and their intervals, and what the command makes of them."""

import gc
import json
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from q2q_model.documents.json_file import with_nulls
from q2q_sim.experiments.endurance.endurance_report import (
    endurance_json,
    endurance_sentence,
    growth_table,
    is_flat,
    measured_growths,
)
from q2q_sim.experiments.endurance.growth import HOUR, Growth, WatchedQuantity, growth
from q2q_sim.experiments.endurance.long_flight import LongFlight, Sample, scenario_of_pairs
from q2q_sim.processes.usage import ProcessUsage, usage_of
from q2q_sim.simulator.flight_clock import FlightTiming

T = np.linspace(0.0, HOUR, 4000)
MEMORY = WatchedQuantity("memory", "MB", 20.0)


def test_the_slope_of_a_line_is_found_after_the_warm_up() -> None:
    filling = np.where(T < 600.0, T / 600.0 * 50.0, 50.0)  # a cache that is full after ten minutes
    found = growth(MEMORY, T, 100.0 + filling + 30.0 * T / HOUR)
    assert found.per_hour == pytest.approx(30.0, rel=1e-9)
    assert found.verdict == "grows"
    assert growth(MEMORY, T, 100.0 + filling).verdict == "flat"
    assert growth(MEMORY, T, 100.0 - 30.0 * T / HOUR).verdict == "falls"


def test_what_never_changes_grows_by_exactly_nothing() -> None:
    found = growth(WatchedQuantity("handles", "", 1.0), T, np.full(len(T), 20.0))
    assert (found.mean, found.per_hour, found.low, found.high) == (20.0, 0.0, 0.0, 0.0)


def test_the_interval_holds_the_slope_in_95_of_100_draws() -> None:
    draw = np.random.default_rng(5)
    inside = 0
    for _ in range(400):
        one = growth(MEMORY, T, 4.0 * T / HOUR + draw.standard_normal(len(T)))
        inside += one.low <= 4.0 <= one.high
    assert 0.915 <= inside / 400 <= 0.985  # 3.2 standard deviations of 400 draws


def test_what_a_short_flight_cannot_show_is_undecided() -> None:
    """A minute of the same noise: the interval of its slope is 60^1.5 times as wide as an hour's."""
    noise = np.random.default_rng(6).standard_normal(120)
    found = growth(MEMORY, np.linspace(0.0, 60.0, 120), 100.0 + noise)
    assert found.high - found.low > 40.0
    assert found.verdict == "undecided"
    few = growth(MEMORY, np.linspace(0.0, 20.0, 40), np.full(40, 7.0))
    assert (few.mean, few.verdict) == (7.0, "undecided")
    assert np.isnan(few.per_hour)


def long_flight(leak: float = 0.0, drift: float = 0.0) -> LongFlight:
    """Return a flight of an hour; `leak` [MB/h] of the recorder, `drift` of the clock [s/h]."""
    samples = [
        Sample(
            wall=7.0 + t * (1.0 - drift / HOUR),
            flown=t,
            usage={
                "pid": ProcessUsage(memory=100_000_000, handles=30, threads=9),
                "bag_record": ProcessUsage(100_000_000 + int(leak * 1e6 * t / HOUR), handles=31, threads=9),
            },
            bag=int(t) * 50_000,
        )
        for t in np.linspace(1.0, HOUR, 2000)
    ]
    return LongFlight(10, live=True, samples=samples, timing=TIMING)


TIMING = FlightTiming(360_000, 0, 1.0, latency_p50_ms=1.0, latency_p99_ms=2.0)


@pytest.mark.parametrize(
    ("leak", "drift", "blamed"),
    [(0.0, 0.0, []), (40.0, 0.0, ["bag_record: memory"]), (0.0, 0.1, ["clock ahead of the wall clock"])],
)
def test_only_what_grows_is_blamed(leak: float, drift: float, blamed: list[str]) -> None:
    flight = long_flight(leak, drift)
    found = measured_growths(flight)
    assert [one.what for one in found if one.verdict != "flat"] == blamed
    assert len(found) == 8
    rate = next(one for one in found if one.what == "bag")
    assert rate.mean == pytest.approx(50.0, rel=1e-3)
    clock = next(one for one in found if one.what == "clock ahead of the wall clock")
    assert abs(clock.mean) < 0.1  # the wall clock begins anywhere
    assert ("all flat" in endurance_sentence(flight, found)) == (not blamed)
    document = endurance_json(flight, found)
    assert isinstance(document, dict)
    assert document["flat"] == (not blamed)


@pytest.mark.parametrize("count", [2, 18])
def test_a_flight_of_few_samples_is_undecided_and_has_its_numbers(count: int) -> None:
    flight = long_flight()
    flight = replace(flight, samples=flight.samples[:count])
    found = measured_growths(flight)
    rate = next(one for one in found if one.what == "bag")
    assert rate.mean == pytest.approx(50.0, rel=0.6)  # of whole seconds
    assert {one.verdict for one in found} == {"undecided"}
    assert growth_table(flight, found).row_count == len(found) == 8
    document = with_nulls(endurance_json(flight, found))
    assert isinstance(document, dict)
    assert json.loads(json.dumps(document, allow_nan=False))["samples"] == count


def test_a_flight_whose_bag_is_cut_is_not_flat() -> None:
    flight = replace(long_flight(), unfinished="No space left on device")
    found = measured_growths(flight)
    assert all(one.verdict == "flat" for one in found)
    assert not is_flat(flight, found)
    assert "does not hold the flight to its end (No space left on device)" in endurance_sentence(
        flight, found
    )


def test_a_quantity_is_flat_only_if_its_whole_interval_is() -> None:
    def judged(low: float, high: float) -> str:
        return Growth("", "", 0.0, 0.5 * (low + high), low, high, 1.0).verdict

    assert [judged(-1.0, 1.0), judged(-3.0, 0.0), judged(0.0, 3.0), judged(1.5, 3.0), judged(-3.0, -2.0)] == [
        "flat",
        "undecided",
        "undecided",
        "grows",
        "falls",
    ]


def test_an_open_file_is_a_handle_of_this_process() -> None:
    gc.collect()  # what others left open is closed now, not while this counts
    before = usage_of(os.getpid())
    with Path(os.devnull).open("rb"):
        during = usage_of(os.getpid())
    assert during.handles == before.handles + 1
    assert during.memory > 1_000_000
    assert during.threads >= 1


def test_upper_vehicles_pass_over_resting_ones_every_ten_seconds() -> None:
    points = scenario_of_pairs(4, 60.0)["vehicles"]
    assert isinstance(points, dict)
    assert [len(one) for one in points.values()] == [7] * 4
    assert {tuple(one["pos"]) for one in points["cf1"]} == {(0.0, 0.0, 1.0)}
    assert [one["pos"][0] for one in points["cf4"]] == pytest.approx([2.6, 1.4] * 3 + [2.6])
