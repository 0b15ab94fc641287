"""Simulator and others in a namespace: its start, use_sim_time, and a recorder whose bag is read."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("q2q_msgs", reason="the workspace is not built")

import rclpy
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.parameter import Parameter
from spun_until import spin_until
from std_srvs.srv import Trigger

from q2q_model.bag import BagReader, read_flight
from q2q_model.ros.node.bounded_spin import make_executor
from q2q_model.ros.node.ready import offer_ready
from q2q_model.ros.topics.messages import MESSAGES
from q2q_model.ros.topics.qos import TICK
from q2q_model.signals.cdr.cdr_format import header_stamp_ns
from q2q_model.signals.stamps import TICK_S
from q2q_model.signals.values import MocapFrame
from q2q_sim.processes.domain import own_domain
from q2q_sim.ros.bag_record_node import Recorder
from q2q_sim.ros.simulator_node import Simulator

FRAMES = 20


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


def made(executor: Executor, name: str, **given: object) -> Node:
    overrides = [Parameter(key, value=value) for key, value in given.items()]
    node = Node(name, namespace="room", parameter_overrides=overrides)
    executor.add_node(node)
    return node


def test_a_simulator_under_sim_time_speaks_and_a_namespaced_recorder_keeps_it(
    executor: Executor, tmp_path: Path
) -> None:
    """The simulator makes the time that it is told to wait for."""
    simulator = Simulator(made(executor, "simulator", use_sim_time=True, pace="live", autostart=False))
    bag = tmp_path / "bag"
    recorder = Recorder(made(executor, "bag_record", bag=str(bag), topics=["mocap"]))
    watcher, seen = made(executor, "watcher"), []
    watcher.create_subscription(MESSAGES[MocapFrame], "mocap", seen.append, TICK, raw=True)
    client = watcher.create_client(Trigger, "simulator/start")
    spin_until(
        executor,
        lambda: client.service_is_ready() and watcher.count_subscribers("/room/mocap") == 2,
        "simulator/start, and two subscriptions to /room/mocap",
    )
    client.call_async(Trigger.Request())
    spin_until(executor, lambda: len(seen) >= FRAMES, f"{FRAMES} frames")
    simulator.close()
    recorder.close()
    assert list(BagReader(bag).topics) == ["/room/mocap"]
    flight = read_flight(bag)
    steps = np.diff(flight.t) / TICK_S
    assert steps.size > 0
    assert steps.min() > 0.5
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-6)  # a busy machine may lose a frame


def test_a_simulator_starts_by_itself_once_the_others_are_connected_and_no_frame_is_lost(
    executor: Executor,
) -> None:
    simulator = Simulator(made(executor, "simulator", pace="live", starts_after=["late"]))
    watcher, frames = made(executor, "watcher"), []
    watcher.create_subscription(MESSAGES[MocapFrame], "mocap", frames.append, TICK, raw=True)
    client = watcher.create_client(Trigger, "simulator/start")
    spin_until(
        executor,
        lambda: client.service_is_ready() and watcher.count_publishers("/room/mocap") == 1,
        "simulator/start, and a publisher of /room/mocap",
    )
    for _ in range(10):
        executor.spin_once(timeout_sec=0.05)
    assert frames == []
    late, seen = made(executor, "late"), []
    late.create_subscription(MESSAGES[MocapFrame], "mocap", seen.append, TICK, raw=True)
    offer_ready(late)
    spin_until(executor, lambda: bool(seen), "the first frame")
    assert header_stamp_ns(seen[0]) == 0
    simulator.close()
