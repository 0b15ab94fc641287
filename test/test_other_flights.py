"""A flight does not start while nodes of another one write its signals."""

from collections.abc import Iterator

import pytest

pytest.importorskip("q2q_msgs", reason="the workspace is not built")

import rclpy
from rclpy.executors import Executor
from rclpy.node import Node

from q2q_model.ros.node.ready import offer_ready
from q2q_model.ros.node.run import make_executor
from q2q_model.ros.topics.messages import MESSAGES
from q2q_model.ros.topics.qos import TICK_WRITER
from q2q_model.signals.values import MocapFrame, SwarmState
from q2q_sim.processes.domain import own_domain
from q2q_sim.ros import flight_director
from q2q_sim.ros.flight_director import FlightDirector

PATIENCE_S = 60.0


@pytest.fixture
def executor() -> Iterator[Executor]:
    with own_domain():
        rclpy.init()
        made = make_executor()
        try:
            yield made
        finally:
            for node in made.get_nodes():
                node.destroy_node()
            rclpy.try_shutdown()


def writer(executor: Executor, name: str, signal: type, topic: str) -> Node:
    node = Node(name)
    node.create_publisher(MESSAGES[signal], topic, TICK_WRITER)
    offer_ready(node)
    executor.add_node(node)
    return node


def test_a_second_writer_of_a_signal_is_named_and_nothing_starts(
    executor: Executor, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(flight_director, "LINGER_S", 0.0)
    writer(executor, "simulator", MocapFrame, "mocap")
    writer(executor, "mocap_filter", SwarmState, "state")
    with FlightDirector(lambda: None, executor) as director:
        director.wait_wired(["simulator", "mocap_filter"], PATIENCE_S)
        writer(executor, "forgotten", MocapFrame, "mocap")
        with pytest.raises(TimeoutError, match=r"^/mocap is written by 2 nodes \(forgotten, simulator\):"):
            director.wait_wired(["simulator", "mocap_filter"], PATIENCE_S)
