"""Flights of scenarios through the nodes within this process.

    parameter file -> start ROS -> stack + simulator + recorder on one executor -> connect -> fly -> end

The nodes are those of `ros2 run q2q_sim stack`, with the simulator and the recorder; messages between
processes there pass through the middleware here, too. ROS and every node are created anew for each flight, so
that only loaded code remains from the one before.
"""

import json
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from time import monotonic

import rclpy
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from std_msgs.msg import String
from std_srvs.srv import Trigger

from q2q_model.node.wiring import undelivered, unmatched
from q2q_model.ros.node.ready import DRAIN, DRAINED, offer_drained, wiring_of
from q2q_model.ros.node.run import make_executor
from q2q_model.ros.topics.qos import LATCHED
from q2q_sim.loop.flight_clock import FlightTiming, timing_of
from q2q_sim.ros import stack
from q2q_sim.ros.bag_record_node import Recorder
from q2q_sim.ros.simulator_node import Simulator

RECORDER, SIMULATOR = "bag_record", "simulator"
WIRE_S = 20.0
"""Time-out for connecting the nodes of one process [s]."""
STILL_S = 60.0
"""Time without an event after which a flight has failed [s]."""
LOOK_S = 0.05
"""Longest wait for the next event [s]."""


@dataclass(frozen=True, slots=True)
class _Cast:
    """Nodes of a flight and their observer."""

    executor: Executor
    nodes: Mapping[Node, object]
    recorder: Recorder
    watcher: Node

    def turn(self) -> None:
        """Process the next event."""
        self.executor.spin_once(timeout_sec=LOOK_S)

    def wait(self, over: Callable[[], bool], patience_s: float, what: str) -> None:
        """Process events until `over` returns true; raise TimeoutError after patience_s [s]."""
        deadline = monotonic() + patience_s
        while not over():
            if monotonic() > deadline:
                raise TimeoutError(f"{what} after {patience_s:g} s")
            self.turn()


def fly_here(parameters: Path, patience_s: float) -> FlightTiming:
    """Fly a parameter file with a section for each node; return the wall-clock timing.

    Raises:
        ValueError: a node refuses a parameter.
        TimeoutError: the nodes do not connect, or the flight is not over after patience_s [s].
    """
    rclpy.init(
        args=["--ros-args", "--params-file", str(parameters)], signal_handler_options=SignalHandlerOptions.NO
    )
    try:
        with _cast() as cast:
            return _flown(cast, patience_s)
    finally:
        rclpy.try_shutdown()


@contextmanager
def _cast() -> Iterator[_Cast]:
    """Yield the nodes of a flight; on exit end them and close the bag."""
    own = Node(RECORDER)
    recorder = Recorder(own)
    offer_drained(own)
    executor = make_executor()
    try:
        road = stack.build()
        simulator = Node(SIMULATOR)
        nodes = {own: recorder, **road, simulator: Simulator(simulator)}
        watcher = Node("flight_director")
        for node in (*nodes, watcher):
            executor.add_node(node)
        yield _Cast(executor, nodes, recorder, watcher)
        for node in (*nodes, watcher):
            executor.remove_node(node)
            node.destroy_node()
    finally:
        recorder.close()
        executor.shutdown()


def _flown(cast: _Cast, patience_s: float) -> FlightTiming:
    told: list[String] = []
    cast.watcher.create_subscription(String, "flight_summary", told.append, LATCHED)
    cast.wait(lambda: _is_wired(cast), WIRE_S, "nodes not wired")
    _ask(cast, f"{SIMULATOR}/start")
    cast.wait(lambda: bool(told), patience_s, "flight not over")
    _drain(cast)
    return timing_of(json.loads(told[0].data))


def _is_wired(cast: _Cast) -> bool:
    wirings = {node.get_name(): wiring_of(node) for node in (*cast.nodes, cast.watcher)}
    return not unmatched(wirings) and not undelivered(wirings)


def _drain(cast: _Cast) -> None:
    """Drain the recorder: it answers after it has taken all earlier messages."""
    for node in cast.nodes:
        for writer in node.publishers:
            writer.wait_for_all_acked(DRAIN)
    _ask(cast, f"{RECORDER}/{DRAINED}")


def _ask(cast: _Cast, service: str) -> None:
    client = cast.watcher.create_client(Trigger, service)
    cast.wait(client.service_is_ready, WIRE_S, f"the service {service} does not answer")
    future = client.call_async(Trigger.Request())
    cast.wait(future.done, WIRE_S, f"the service {service} does not answer")
