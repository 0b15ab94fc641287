"""Messages of other programs do not end the tool that directs a flight."""

import json
import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest

pytest.importorskip("q2q_msgs", reason="the workspace is not built")

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String
from std_srvs.srv import Trigger

from q2q_model.ros.topics.qos import LATCHED
from q2q_sim.processes.domain import own_domain
from q2q_sim.ros.flight_director import FlightDirector
from q2q_sim.simulator.flight_clock import FlightTiming, timing_as_text

TIMEOUT_S = 30.0
"""Longest wait for an answer [s]."""


@contextmanager
def node_of_others(name: str) -> Iterator[Node]:
    """Yield a node; destroy it even if a test fails: one left behind would disturb flights of other tests."""
    node = Node(name)
    try:
        yield node
    finally:
        node.destroy_node()


def refusing(message: str) -> Callable[[Trigger.Request, Trigger.Response], Trigger.Response]:
    """Return the callback of a service that answers with a message and no success."""

    def answer(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.message = message
        return response

    return answer


TIMING = FlightTiming(100, 2, 1.5, None, 3.25)
FIELDS = json.loads(timing_as_text(TIMING))


@pytest.mark.parametrize(
    ("summary", "why"),
    [
        ("over", "not JSON"),
        ("[" * 100_000, "not JSON"),
        ("3", "a mapping"),
        ("{}", "ticks"),
        (json.dumps(FIELDS | {"ticks": "many"}), "ticks"),
        (json.dumps(FIELDS | {"latency_p50_ms": math.nan}), "latency_p50_ms"),
    ],
)
def test_a_summary_that_is_no_timing_is_refused_with_the_node_that_writes_it(summary: str, why: str) -> None:
    others = "(_NODE_NAME_UNKNOWN_, )*"  # of a flight in this domain that has just ended
    said = rf"^/flight_summary of {others}stranger is .*{why}[^\n]*ROS_DOMAIN_ID$"
    with own_domain(), FlightDirector(lambda: None) as director, node_of_others("stranger") as stranger:
        stranger.create_publisher(String, "flight_summary", LATCHED).publish(String(data=summary))
        with pytest.raises(ValueError, match=said):
            director.wait_summary(lambda _: None)


def test_a_summary_is_refused_where_two_simulators_fly() -> None:
    said = r"^another flight was in this ROS domain \(/flight_summary is written by one, simulator\)"
    with (
        own_domain(),
        FlightDirector(lambda: None) as director,
        node_of_others("simulator") as ours,
        node_of_others("one") as stranger,
    ):
        for node in (ours, stranger):
            node.create_publisher(String, "flight_summary", LATCHED)
        director._on_summary(String(data=timing_as_text(TIMING)))
        with pytest.raises(ValueError, match=said):
            director.wait_summary(lambda _: None)


def test_a_summary_is_the_timing_of_the_flight() -> None:
    with own_domain(), FlightDirector(lambda: None) as director:
        director._on_summary(String(data=timing_as_text(TIMING)))
        assert director.wait_summary(lambda _: None) == TIMING


def test_a_node_that_is_not_of_q2q_is_named_with_what_it_answers() -> None:
    with own_domain(), FlightDirector(lambda: None) as director, node_of_others("pid") as stranger:
        stranger.create_service(Trigger, "~/ready", refusing("as ready as can be"))
        director._executor.add_node(stranger)
        with pytest.raises(ValueError, match=r"^pid answers 'as ready as can be' to ~/ready"):
            director.wait_connected(("pid",), TIMEOUT_S)
        director._executor.remove_node(stranger)


def test_a_start_that_is_refused_ends_the_flight_with_the_answer() -> None:
    with own_domain(), FlightDirector(lambda: None) as director, node_of_others("simulator") as flying:
        flying.create_service(Trigger, "~/start", refusing("already flying"))
        director._executor.add_node(flying)
        with pytest.raises(ValueError, match=r"^simulator refuses to start: already flying$"):
            director.start()
        director._executor.remove_node(flying)


def test_diagnostics_and_the_clock_are_the_ticks_flown() -> None:
    with own_domain(), FlightDirector(lambda: None) as director:
        values = [KeyValue(key="ticks", value="12")]
        status = DiagnosticStatus(name="/other/simulator", values=values)
        director._on_diagnostics(DiagnosticArray(status=[status]))
        assert director.ticks == 12
        director._on_clock(Clock(clock=Time(sec=1, nanosec=20_000_000)))
        assert director.ticks == 102
