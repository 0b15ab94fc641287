"""The table of flights in a terminal of any width has every number and every name whole."""

import json
import math
from dataclasses import replace
from pathlib import Path

import pytest

from q2q_model.plain_console import plain_console
from q2q_sim.loop.flight_recorder import FlightRecorder
from q2q_sim.monitors.flight_verdict import FlightVerdict
from q2q_sim.monitors.metrics.flight_metrics import FlightMetrics, VehicleMetrics
from q2q_sim.node_flights.flight_request import FlightRequest
from q2q_sim.node_flights.flight_run import FlightRun, runs_json
from q2q_sim.report.run_table import run_notes, run_table, run_verdicts
from q2q_sim.simulator.flight_clock import FlightTiming

TABLE6 = FlightRequest("table6")
SHORT = ("cf1", "cf2")
LONG = tuple(f"crazyflie_number_{each}_of_the_great_western_laboratory" for each in (1, 2))
NUMBERS = ("0.0226", "0.0471", "0.564", "-0.0286", "0.358", "0.0176")


def run_of(names: tuple[str, ...], request: FlightRequest) -> FlightRun:
    """Return a finished flight."""
    one = VehicleMetrics(0.0226, 0.0471, 0.564, -0.0286, 0.358, 0.0, 0.0, 0.0)
    return FlightRun(
        request,
        FlightRecorder(names, 1).flight("made"),
        FlightMetrics(dict.fromkeys(names, one), 0.0176, 0.0),
        FlightTiming(0, 0, None, None, None),
        Path("bag"),
        FlightVerdict(10.0),
    )


def words(names: tuple[str, ...], width: int, request: FlightRequest = TABLE6) -> list[str]:
    """Return the words of a table that is printed in a terminal of some width."""
    run = run_of(names, request)
    console = plain_console(width=width)
    with console.capture() as printed:
        console.print(run_table([run], width))
    lines = printed.get().splitlines()
    assert max(map(len, lines)) <= width
    return " ".join(lines).split()


@pytest.mark.parametrize("width", [20, 40, 60, 74, 80, 120])
@pytest.mark.parametrize("names", [SHORT, LONG])
def test_numbers_are_whole_at_any_width(names: tuple[str, ...], width: int) -> None:
    found = words(names, width)
    assert [found.count(number) for number in NUMBERS] == [2] * len(NUMBERS)


@pytest.mark.parametrize("width", [30, 40, 80])
def test_a_long_name_is_broken_and_not_cut(width: int) -> None:
    """Its parts are the words that are not in a table with short names."""
    others = set(words(SHORT, width))
    parts = [word for word in words(LONG, width) if word not in others and set(word) != {"─"}]
    assert "".join(parts) == "".join(LONG)


def test_a_row_for_each_vehicle_where_it_fits() -> None:
    assert words(SHORT, 80)[-16:-8] == ["aware", "cf1", *NUMBERS]


def test_the_path_of_a_scenario_is_printed_as_it_is() -> None:
    assert words(SHORT, 80, FlightRequest("sc[red].yaml"))[:2] == ["sc[red].yaml,", "pid"]


def test_one_vehicle_has_no_time_in_the_zone() -> None:
    run = run_of(("cf1",), TABLE6)
    alone = replace(run, metrics=replace(run.metrics, zone_time_s=math.nan))
    assert run_notes([run])[0].startswith("aware: 0 s in the zone, - x real time")
    assert run_notes([alone])[0].startswith("aware: - x real time")


@pytest.mark.parametrize(("mode", "said"), [("ignoring", "ignoring"), ("aware_unlimited", "no limit")])
def test_a_corrected_flight_is_told_from_one_that_is_not(mode: str, said: str) -> None:
    plain, corrected = (
        run_of(SHORT, FlightRequest("table6", mode, correct=correct)) for correct in (False, True)
    )
    assert "corrected" not in words(SHORT, 80, plain.request)
    assert words(SHORT, 80, corrected.request).count("corrected") == len(SHORT)
    assert run_notes([plain, corrected])[0].startswith(f"{said}: ")
    assert run_notes([plain, corrected])[1].startswith(f"{said}, corrected: ")
    ends = "ok: 10.0 s flown to the end"
    assert run_verdicts([plain, corrected]) == f"verdict: {said}: {ends} | {said}, corrected: {ends}"
    flown = json.loads(json.dumps(runs_json([plain, corrected])))["runs"]
    assert [(one["mode"], one["correct"]) for one in flown] == [(mode, False), (mode, True)]
