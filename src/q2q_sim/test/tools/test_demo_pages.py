"""The demos: which flights they take, and the numbers that they show large."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from q2q_model.downwash.jet import MEASURED_LAW
from q2q_model.flights.duplicates.same_flight import flight_digest
from q2q_model.identification.jet.held_out_flights import HeldOutFlight, HeldOutScores
from q2q_model.identification.push.along_flight import Motion
from q2q_model.identification.push.push_samples import PushSamples, PushScore
from q2q_model.model_files.find_model import find_model
from q2q_model.recordings.recording_reader import recording_of_bag
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, Waypoint
from q2q_sim.loop.closed_loop import FlightOptions, fly
from q2q_sim.loop.flight_recorder import FlightRecorder
from q2q_sim.monitors.flight_judgement import verdict_of
from q2q_sim.monitors.metrics.flight_metrics import FlightMetrics, VehicleMetrics, measure
from q2q_sim.monitors.policies import Circumstances
from q2q_sim.node_flights.flight_request import FlightRequest
from q2q_sim.node_flights.flight_run import FlightRun
from q2q_sim.report.run_table import run_notes
from q2q_sim.scenarios import library
from q2q_sim.simulator.flight_clock import FlightTiming
from q2q_sim.tools.demo import real_flight
from q2q_sim.tools.demo.demo_flights import key_numbers, passage_times, write_demo_page
from q2q_sim.tools.demo.real_flight_page import median_flight, write_real_page

QUICK = (
    VehicleWaypoints("cf1", (Waypoint(0.0, (0.0, 0.0, 1.5)), Waypoint(6.0, (0.0, 0.0, 1.5)))),
    VehicleWaypoints("cf2", (Waypoint(0.0, (0.0, 0.4, 2.0)), Waypoint(6.0, (0.0, -0.4, 2.0)))),
)
"""A passage 0.5 m above another vehicle, under way when metrics begin (3 s)."""


def metrics(**worst: float) -> FlightMetrics:
    """Return the metrics of a flight with the worst height error of each vehicle [m]."""
    vehicles = {name: VehicleMetrics(*[0.0] * 7, worst_m=error) for name, error in worst.items()}
    return FlightMetrics(vehicles, 1.0, 0.0)


def test_the_two_numbers_are_of_the_vehicle_that_is_pushed_most() -> None:
    ignoring = metrics(cf1=0.34244, cf2=math.nan, cf3=0.2)
    pushed, left = key_numbers(ignoring, metrics(cf1=0.10925, cf2=math.nan, cf3=0.3))
    assert (pushed.value, left.value) == ("34 cm", "11 cm")
    assert "height error of cf1" in pushed.meaning  # up or down: the worst one with q2q is often upwards


def test_without_a_vehicle_under_another_there_are_no_numbers() -> None:
    assert key_numbers(metrics(cf1=math.nan), metrics(cf1=math.nan)) == []


def test_the_passage_is_the_time_under_another_and_three_seconds_around_it() -> None:
    t = np.arange(0.0, 20.0, 0.1)
    pos = np.zeros((len(t), 2, 3))
    pos[:, 1] = np.stack([t - 10.0, 0.0 * t, np.full(len(t), 0.5)], axis=1)  # within 0.15 m at 9.9 to 10.1 s
    flight = replace(FlightRecorder(("cf1", "cf2"), len(t)).flight("made"), t=7.0 + t, true_pos=pos)
    assert passage_times(flight) == pytest.approx((6.9, 13.1), abs=0.001)
    pos[:, 1, 1] = 5.0
    assert passage_times(flight) == pytest.approx((0.0, 19.9))


def test_real_flights_are_for_training_unless_the_air_was_learned_from_their_family(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "neural_swarm"
    folder.mkdir()
    for name in (
        "dc19_swap_ss_02",
        "dc19_walk_ss_04",
        "dc21_swap_ss_03",
        "dc21_walk_sss_99",
        "dc21_walk_s_00",
    ):
        (folder / f"{name}.parquet").touch()
    monkeypatch.setenv("Q2Q_DATA", str(tmp_path))
    found = real_flight.find_flights([])
    assert [one.stem for one in found.training] == ["dc19_swap_ss_02", "dc19_walk_ss_04"]
    assert [one.stem for one in found.further] == ["dc21_swap_ss_03", "dc21_walk_sss_99"]


def test_without_real_flights_it_says_where_they_are_found_and_takes_the_shipped_ones(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("Q2Q_DATA", str(tmp_path))
    found = real_flight.find_flights([])
    assert [one.name for one in found.training] == [f"table2_{k}" for k in range(1, 7)]
    assert found.further == ()
    assert "https://github.com/aerorobotics/neural-swarm" in found.origin
    assert "simulated" in found.origin


def test_given_flights_come_first() -> None:
    assert real_flight.find_flights([Path("mine")]).training == (Path("mine"),)


def test_without_any_flight_it_asks_for_some(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("Q2Q_DATA", str(tmp_path))
    monkeypatch.setattr(real_flight, "SHIPPED_BAGS", tmp_path)
    with pytest.raises(ValueError, match=r"scripts/demo --real FLIGHT\.\.\."):
        real_flight.find_flights([])


def test_the_model_knows_its_flights_by_their_digests(monkeypatch: pytest.MonkeyPatch) -> None:
    bags = tuple(real_flight.SHIPPED_BAGS / f"table2_{k}" for k in (1, 2))
    others = [
        HeldOutFlight(one.name, (), (), PushScore(0.9, None, None, 1), (other.name,))
        for one, other in (bags, bags[::-1])
    ]
    scores = HeldOutScores(MEASURED_LAW, tuple(others))
    monkeypatch.setattr(real_flight, "held_out_scores", lambda *_: scores)
    fit = real_flight.score_flights(real_flight.DemoFlights(bags, (), "")).fit
    assert fit.flights == ("table2_1", "table2_2")
    assert fit.digests == tuple(flight_digest(recording_of_bag(one).flight) for one in bags)


def test_the_pictured_flight_is_neither_the_best_nor_the_worst() -> None:
    flights = [
        HeldOutFlight(name, (), (), PushScore(r2, None, None, 1), ())
        for name, r2 in (("best", 0.95), ("none", None), ("worst", 0.7), ("middle", 0.9))
    ]
    assert median_flight(flights).name == "middle"


@pytest.fixture(scope="module")
def runs() -> list[FlightRun]:
    """Return a passage in 6 s, ignoring the downwash and aware of it."""
    scenario = replace(library.load("table6"), waypoints=QUICK, duration=6.0)
    model = find_model(scenario.model).interaction
    timing = FlightTiming(600, 0, 10.0, latency_p50_ms=1.0, latency_p99_ms=2.0)
    found = []
    for mode in ("ignoring", "aware"):
        flight = fly(scenario, FlightOptions(mode, model=model))
        around = Circumstances(vehicle=scenario.vehicle)
        metrics, verdict = measure(flight, scenario.vehicle), verdict_of(flight, around, 0)
        found.append(FlightRun(FlightRequest("table6", mode), flight, metrics, timing, Path("bag"), verdict))
    return found


def test_the_demo_shows_replay_numbers_and_table_in_this_order(runs: list[FlightRun], tmp_path: Path) -> None:
    write_demo_page(runs, tmp_path)
    html = (tmp_path / "index.html").read_text()
    pushed, left = key_numbers(runs[0].metrics, runs[1].metrics)
    order = ["<h1>", "<q2q-replay>", f"<b>{pushed.value}</b>", f"<b>{left.value}</b>", "<table>", "<img "]
    places = [html.index(one) for one in order]
    assert places == sorted(places)
    words = " ".join(html.split())
    assert "10 x real time, 0 ticks missed, mocap to command 1.0 ms in the median, 2.0 ms at p99" in words
    assert html.count("<img ") == 4  # altitude and thrust of two vehicles


def test_the_timing_of_a_flight_fits_a_terminal_of_80_columns(runs: list[FlightRun]) -> None:
    slow = FlightTiming(360_000, 123_456, 0.012, latency_p50_ms=123.4, latency_p99_ms=1234.5)
    far = replace(runs[0].metrics, zone_time_s=1234.5)
    request = replace(runs[0].request, mode="aware_unlimited")
    (message,) = run_notes([replace(runs[0], timing=slow, metrics=far, request=request)])
    assert message.startswith("no limit: 1230 s in the zone, 0.012 x real time, 123456 ticks missed,\n")
    assert max(map(len, message.splitlines())) <= 80


def test_the_page_on_recorded_flights_pictures_the_typical_one_and_lists_all(
    runs: list[FlightRun], tmp_path: Path
) -> None:
    t, under = np.arange(0.0, 1.0, 0.01), np.arange(100) > 50
    motion = Motion(t, np.zeros((100, 2, 3)), np.zeros((100, 2, 3)), np.zeros((100, 2, 3)))
    samples = PushSamples("one", motion, 0, np.sin(t), under | True, under, ~under)
    flights = tuple(
        HeldOutFlight(name, (samples,), (0.9 * np.sin(t),), PushScore(r2, 0.1, 0.0, 49, 0.95), ("other",))
        for name, r2 in (("good", 0.9), ("typical", 0.8), ("poor", 0.5))
    )
    write_real_page("Made flights.", HeldOutScores(MEASURED_LAW, flights), runs, tmp_path)
    html = (tmp_path / "index.html").read_text()
    assert "typical, the flight of median R2" in html
    assert all(f">{one.name}</td>" in html for one in flights)
    assert html.index("<q2q-replay>") < html.index("R2 0.99") < html.index("<img ")  # 1 - 0.1^2
    assert (tmp_path / "prediction.png").is_file()
