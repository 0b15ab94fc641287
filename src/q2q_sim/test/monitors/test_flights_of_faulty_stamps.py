"""The record of a flight whose frames have other stamps than their ticks is that of the flight itself."""

from collections import defaultdict
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import yaml

from q2q_model.bag import BagWriter, read_flight
from q2q_model.flights.flight import Flight
from q2q_model.flights.joined_flight import flight_from_signals
from q2q_model.signals.layout import Signal
from q2q_model.signals.some_vehicles import of_vehicles
from q2q_model.signals.stamps import stamp_from_time
from q2q_sim.loop.closed_loop import FlightOptions, fly
from q2q_sim.monitors.flight_judgement import verdict_of
from q2q_sim.monitors.metrics.flight_metrics import measure
from q2q_sim.monitors.policies import Circumstances, trace_in_lockstep
from q2q_sim.scenarios.scenario import Scenario
from q2q_sim.scenarios.scenario_document import scenario_from_document

FAULTS = {
    "repeated": "{kind: repeated, start: 0.85, duration: 0.3}",
    "late": "{kind: late, start: 0.85, duration: 0.3, size: 0.2}",
    "reordered": "{kind: reordered, start: 0.85, duration: 0.3}",
    "ahead": "{kind: clock_jump, start: 0.85, duration: 0.5, size: 100.0}",
    "back for good": "{kind: clock_jump, start: 0.85, duration: 9.0, size: -0.4}",
}
ROOM = """
{duration: 2.0, room: ideal, vehicles: {
  cf1: [{t: 0, pos: [0, 0, 1]}, {t: 2, pos: [0, 0, 1]}],
  cf2: [{t: 0, pos: [-0.5, 0.1, 1]}, {t: 2, pos: [0.5, 0.1, 1]}]}}
"""
ANSWERED = ("ref_pos", "safe_pos", "eta", "thrust", "roll", "pitch", "command_status", "true_pos")


Signals = dict[str, list[Signal]]


def scenario(fault: str) -> Scenario:
    """Return a flight in which cf2 passes cf1 in contact with it, under a fault if one is named."""
    faults = [yaml.safe_load(FAULTS[fault])] if fault else []
    return scenario_from_document("pass", yaml.safe_load(ROOM) | {"faults": faults})


@cache
def flown(fault: str) -> tuple[Flight, Signals]:
    """Return the flight in arrays, tick by tick, and the signals that its nodes would record."""
    signals: Signals = defaultdict(list)
    flight = fly(
        scenario(fault), FlightOptions(on_signal=lambda topic, _, signal: signals[topic].append(signal))
    )
    return flight, signals


@pytest.mark.parametrize("fault", FAULTS)
def test_what_was_flown_at_a_tick_is_recorded_at_that_tick(fault: str) -> None:
    flight, signals = flown(fault)
    recorded, trace = flight_from_signals("recorded", signals).flight, trace_in_lockstep(signals)
    np.testing.assert_array_equal(recorded.t, flight.t)
    for name in ANSWERED:
        np.testing.assert_array_equal(getattr(recorded, name), getattr(flight, name), name)
    np.testing.assert_array_equal(trace.sent_pos, flight.safe_pos)


@pytest.mark.parametrize("fault", FAULTS)
def test_a_collision_while_frames_have_other_stamps_is_in_the_verdict_of_the_record(fault: str) -> None:
    flight, signals = flown(fault)
    recorded = flight_from_signals("recorded", signals).flight
    around = Circumstances(faults=scenario(fault).faults)
    assert "cf1 and cf2 collided" in str(verdict_of(flight, around))
    assert str(verdict_of(recorded, around)) == str(verdict_of(flight, around))
    of_both = [measure(one, around.vehicle).min_separation_m for one in (recorded, flight)]
    assert of_both[0] == of_both[1] < 0.13


@pytest.mark.filterwarnings("ignore::q2q_model.bag.BagRepairWarning")
@pytest.mark.parametrize("fault", FAULTS)
def test_a_bag_in_the_time_of_headers_has_each_answer_at_its_tick(fault: str, tmp_path: Path) -> None:
    flight, signals = flown(fault)
    with BagWriter(tmp_path / "bag") as writer:
        for topic, some in signals.items():
            for one in some:
                writer.write_signal(f"/{topic}", stamp_from_time(one.t), one)
    recorded = read_flight(tmp_path / "bag")
    for name in ANSWERED:
        np.testing.assert_array_equal(getattr(recorded, name), getattr(flight, name), name)


def sent_again(signals: Signals, tick: int) -> Signals:
    """Return the signals of a loop that sends one frame again, which its nodes answer again."""
    once = ("truth", "truth_interference", "imu")
    return {
        topic: some if topic in once else some[: tick + 1] + some[tick:] for topic, some in signals.items()
    }


@pytest.mark.parametrize("fault", FAULTS)
def test_a_frame_that_is_sent_again_moves_no_answer(fault: str) -> None:
    _, signals = flown(fault)
    whole = flight_from_signals("recorded", signals).flight
    recorded = flight_from_signals("recorded", again := sent_again(signals, 20)).flight
    for name in ANSWERED:
        np.testing.assert_array_equal(getattr(recorded, name), getattr(whole, name), name)
    np.testing.assert_array_equal(trace_in_lockstep(again).sent_pos, whole.safe_pos)


@pytest.mark.parametrize("fault", FAULTS)
def test_each_vehicle_may_have_a_controller_of_its_own(fault: str) -> None:
    _, signals = flown(fault)
    whole = flight_from_signals("recorded", signals).flight
    each = [of_vehicles(one, np.array([row])) for one in signals["command"] for row in (0, 1)]
    for commands in (each, each[:41] + each[40:]):  # cf1 is sent the frame of a tick again
        recorded = flight_from_signals("recorded", signals | {"command": commands}).flight
        for name in ("thrust", "roll", "pitch", "command_status"):
            np.testing.assert_array_equal(getattr(recorded, name), getattr(whole, name), name)


def test_frames_that_the_record_lacks_do_not_hide_what_the_vehicles_did() -> None:
    _, signals = flown("repeated")
    frames = [one for one in signals["mocap"] if not 0.6 < one.t < 1.4]
    recorded = flight_from_signals("recorded", signals | {"mocap": frames}).flight
    assert len(recorded.t) == 200
    assert "cf1 and cf2 collided" in str(verdict_of(recorded, Circumstances()))


@pytest.mark.parametrize("kind", ["lost", "ended", "of a lower rate", "of a higher rate"])
def test_truth_that_is_not_recorded_at_every_tick_hides_no_collision(kind: str) -> None:
    _, signals = flown("")
    truth = signals["truth"]
    kept = {
        "lost": [one for one in truth if not 0.5 < one.t < 1.5],
        "ended": truth[:50],
        "of a lower rate": truth[::5],
        "of a higher rate": [replace(one, t=one.t + late) for one in truth for late in (0.0, 0.005)],
    }
    recorded = flight_from_signals("recorded", signals | {"truth": kept[kind]}).flight
    assert len(recorded.t) == 200
    said = str(verdict_of(recorded, Circumstances()))
    assert said == str(verdict_of(flight_from_signals("whole", signals).flight, Circumstances()))
    assert said.startswith("cf1 and cf2 collided")


def test_an_answer_that_is_lost_leaves_the_others_at_their_stamps() -> None:
    _, signals = flown("repeated")
    recorded = flight_from_signals("recorded", signals | {"command": signals["command"][1:]}).flight
    known = np.isfinite(recorded.thrust[:, 0])
    assert not known[0]
    assert set(recorded.t[known]) <= {one.t for one in signals["command"]}
