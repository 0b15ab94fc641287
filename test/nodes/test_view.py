"""A viewer receives what the signals contain: markers for RViz, the same scene for Foxglove."""

import struct
import sys

import numpy as np
import pytest
import yaml
from foxglove_client import FoxgloveClient
from fresh_checkout import ROOT
from open_ports import addresses_of
from resting_signals import resting_state
from visualization_msgs.msg import Marker, MarkerArray

from q2q_model.flights.flight import Flight
from q2q_model.model_files.find_model import find_model
from q2q_model.ros.topics.messages import MESSAGES
from q2q_model.ros.topics.plan_message import encode_plan
from q2q_model.signals.cdr.cdr_writer import encode
from q2q_model.signals.layout import Signal
from q2q_model.signals.values import Interference
from q2q_sim.loop.closed_loop import FlightOptions, fly
from q2q_sim.loop.flight_blocks import plan_of
from q2q_sim.ros.stand_in import StandInNode
from q2q_sim.ros.view_node import View
from q2q_sim.scenarios import library
from q2q_sim.view import foxglove_server
from q2q_sim.view.scene import SceneParams

TIMEOUT_S = 60.0
"""A busy machine answers within this; the test itself waits for nothing else."""
WAIT_S = 0.05
"""Between two states that are shown while no viewer has subscribed yet."""
STEP = 20
"""Ticks between two states that are shown: 5 Hz of a recorded flight."""


class Viewed(StandInNode):
    """Messages that the view publishes."""

    def __init__(self, **given: bool | float) -> None:
        super().__init__("view", given)
        self.markers: list[MarkerArray] = []

    def create_publisher(self, kind: type, topic: str, qos: object) -> object:
        """Be the publisher of the scene."""
        made = super().create_publisher(kind, topic, qos)
        return self if topic == "scene" else made

    def publish(self, message: MarkerArray) -> None:
        """Keep a scene."""
        self.markers.append(message)

    def hear(self, signal: Signal, stamp_ns: int) -> None:
        """Let the view receive a signal."""
        for message, receive in self.readers:
            if message is MESSAGES[type(signal)]:
                receive(encode(signal, stamp_ns))


@pytest.fixture(scope="module")
def flight() -> Flight:
    """Return Q2's pass over Q1, flown without ROS."""
    scenario = library.load("table6")
    return fly(scenario, FlightOptions(model=find_model(scenario.model).interaction))


def shown(node: StandInNode, flight: Flight, tick: int) -> None:
    """Pass one tick of a flight to the view."""
    t, n = float(flight.t[tick]), len(flight.names)
    flags = np.zeros(n, dtype=np.uint8)
    spread = np.full((n, 3), np.nan)
    downwash = Interference(t, flight.names, flight.eta[tick], spread, flags)
    state = resting_state(t, flight.names, flight.pos[tick], quat=flight.quat[tick])
    node.hear(downwash, round(t * 1e9))
    node.hear(state, round(t * 1e9))


def test_markers_stand_where_the_state_says_in_every_tick_of_a_flight(flight: Flight):
    node = Viewed(scene_hz=100.0)
    View(node)
    ticks = range(0, len(flight.t), STEP)
    for tick in ticks:
        shown(node, flight, tick)
    assert len(node.markers) == len(ticks)
    for tick, message in zip(ticks, node.markers, strict=True):
        stamp = message.markers[1].header.stamp
        assert stamp.sec * 1_000_000_000 + stamp.nanosec == round(flight.t[tick] * 1e9)
        boxes = [one for one in message.markers if one.ns == "vehicle"]
        at = [[one.pose.position.x, one.pose.position.y, one.pose.position.z] for one in boxes]
        assert at == flight.pos[tick].tolist()


def test_force_arrows_are_the_predicted_downwash(flight: Flight):
    node = Viewed(scene_hz=100.0)
    View(node)
    worst = int(np.argmin(flight.eta[:, 0, 2]))
    shown(node, flight, worst)
    arrow = next(one for one in node.markers[0].markers if one.ns == "force" and one.id == 0)
    tail, tip = arrow.points
    # The tip is tail + scale eta: one rounding of numbers near 1.
    assert (tip.z - tail.z) / SceneParams().force_scale == pytest.approx(flight.eta[worst, 0, 2], rel=1e-12)
    assert flight.eta[worst, 0, 2] < -0.1  # it pushes down, and not by nothing


def test_the_first_marker_clears_what_was_drawn_before(flight: Flight):
    node = Viewed()
    View(node)
    shown(node, flight, 0)
    actions = [one.action for one in node.markers[0].markers]
    assert actions[0] == Marker.DELETEALL
    assert set(actions[1:]) == {Marker.ADD}


def test_the_plan_is_drawn_when_it_comes(flight: Flight):
    node = Viewed(scene_hz=100.0)
    View(node)
    shown(node, flight, 0)
    plan = plan_of(library.load("table6"))
    for message, receive in node.readers:
        if message.__name__ == "Plan":
            receive(encode_plan(plan, 0))
    shown(node, flight, STEP)
    before, after = ([one for one in each.markers if one.ns == "plan"] for each in node.markers)
    assert before == []
    end = after[1].points[-1]
    assert [end.x, end.y, end.z] == pytest.approx(plan.trajectories[1].at(np.array([1e9]))[0, :3], abs=1e-9)


def test_a_headless_foxglove_client_receives_the_scene(flight: Flight):
    pytest.importorskip("foxglove", reason="foxglove-sdk is optional: pip install -r requirements/view.txt")
    node = Viewed(foxglove=True, foxglove_port=0, scene_hz=100.0)
    view = View(node)
    assert view.foxglove is not None
    try:
        assert addresses_of("tcp", view.foxglove.port) == {"127.0.0.1"}
        assert addresses_of("tcp6", view.foxglove.port) == set()
        with FoxgloveClient(view.foxglove.port, TIMEOUT_S) as client:
            assert client.subscribe(foxglove_server.TOPIC) == "foxglove.SceneUpdate"
            for tick in range(0, len(flight.t), STEP):  # the flight goes on; the viewer joins when it can
                shown(node, flight, tick)
                if (got := client.poll(WAIT_S)) is not None:
                    break
    finally:
        view.close()
    assert got is not None
    seen = round(got.log_time_ns * 1e-9 / (flight.t[1] - flight.t[0]))
    assert seen % STEP == 0
    for number in flight.pos[seen].ravel():  # protobuf: a double is eight bytes, little endian
        assert number == 0.0 or struct.pack("<d", number) in got.payload
    assert b"vehicle/cf1" in got.payload
    assert b"zone/cf2" in got.payload


def test_without_the_sdk_one_line_says_what_to_install(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setitem(sys.modules, "foxglove", None)
    with pytest.raises(ValueError, match=r"pip install -r requirements/view\.txt"):
        View(Viewed(foxglove=True, foxglove_port=0))


def test_rviz_shows_every_group_of_the_scene(flight: Flight):
    config = yaml.safe_load((ROOT / "src/q2q_sim/config/q2q.rviz").read_text())
    display = next(one for one in config["Visualization Manager"]["Displays"] if one["Name"] == "Scene")
    node = Viewed(scene_hz=100.0)
    View(node)
    for tick in range(0, len(flight.t), STEP):
        shown(node, flight, tick)
    drawn = {one.ns for message in node.markers for one in message.markers if one.ns}
    assert drawn <= set(display["Namespaces"])
    assert display["Topic"]["Value"] == "/scene"
