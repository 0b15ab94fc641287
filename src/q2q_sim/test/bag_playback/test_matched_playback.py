"""A player that starts by itself loses no message of a node that runs, by rate and tick by tick."""

from pathlib import Path
from time import monotonic

import pytest

pytest.importorskip("q2q_msgs", reason="the workspace is not built")

import rclpy
from q2q_msgs import msg as messages
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

from q2q_model.bag import BagWriter
from q2q_model.node.warm_up import synthetic_signal
from q2q_model.ros.node.bounded_spin import make_executor
from q2q_model.ros.topics.qos import TICK_WRITER
from q2q_model.signals.cdr.cdr_format import header_stamp_ns
from q2q_model.signals.values import MocapFrame
from q2q_sim.processes.domain import own_domain
from q2q_sim.ros.bag_play_node import Player

TIMEOUT_S = 30.0
"""Longest wait for a message [s]."""
TICKS = 5


@pytest.mark.parametrize("given", [(), ("-p", "wait_for:=interference")])
def test_a_running_node_hears_every_message_once(tmp_path: Path, given: tuple[str, ...]) -> None:
    with BagWriter(tmp_path / "bag") as writer:
        for tick in range(TICKS):
            frame = synthetic_signal(MocapFrame, tick / 100.0, ("cf1",))
            writer.write_signal("/mocap", tick * 10_000_000, frame)
    heard: list[int] = []
    with own_domain():
        there = Context()
        rclpy.init(context=there)
        rclpy.init(args=["--ros-args", "-p", f"bag:={tmp_path / 'bag'}", *given])
        node = Node("reader", context=there)
        answers = node.create_publisher(messages.Interference, "interference", TICK_WRITER)

        def hear(data: bytes) -> None:
            heard.append(header_stamp_ns(data) // 10_000_000)
            answers.publish(data)  # its header is that of the tick

        node.create_subscription(messages.MocapFrame, "mocap", hear, TICK_WRITER, raw=True)
        reading, playing = SingleThreadedExecutor(context=there), make_executor()
        player_node = Node("bag_play")
        Player(player_node)
        reading.add_node(node)
        playing.add_node(player_node)
        end = monotonic() + TIMEOUT_S
        while heard[-1:] != [TICKS - 1] and monotonic() < end:
            playing.spin_once(timeout_sec=0.01)
            reading.spin_once(timeout_sec=0.0)
        for one in (node, player_node):
            one.destroy_node()
        rclpy.try_shutdown(context=there)
        rclpy.try_shutdown()
    assert heard == list(range(TICKS))
