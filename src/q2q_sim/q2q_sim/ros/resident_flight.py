"""Fly a scenario through the nodes within this very process, flight after flight.

    parameter file -> ROS starts -> stack + simulator + recorder on one executor -> wired -> flown -> ended

The nodes are those of `ros2 run q2q_sim stack`, with the simulator and the recorder beside them; what crosses
between processes there crosses the middleware here, too. ROS and every node are made anew for each flight,
so that nothing is left of the one before but loaded code: which is what starting processes costs.
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
"""How long nodes of one process may take to find each other [s]."""
STILL_S = 60.0
"""A flight in which nothing happens for this long has failed [s]."""
LOOK_S = 0.05
"""Longest wait for the next event [s]."""


@dataclass(frozen=True, slots=True)
class _Cast:
    """Nodes of a flight and their watcher."""

    executor: Executor
    nodes: Mapping[Node, object]
    recorder: Recorder
    watcher: Node

    def turn(self) -> None:
        """Let the next event happen."""
        self.executor.spin_once(timeout_sec=LOOK_S)

    def wait(self, over: Callable[[], bool], patience_s: float, what: str) -> None:
        """Let events happen until it is over; raise TimeoutError after patience_s [s]."""
        deadline = monotonic() + patience_s
        while not over():
            if monotonic() > deadline:
                raise TimeoutError(f"{what} after {patience_s:g} s")
            self.turn()


def fly_here(parameters: Path, patience_s: float) -> FlightTiming:
    """Fly what a parameter file says, with a section for each node; return how it went in wall time.

    Raises:
        ValueError: a parameter that a node refuses.
        TimeoutError: nodes that do not find each other, or a flight not over after patience_s [s].
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
    """Hold the nodes of a flight; leaving it ends them and finishes the bag."""
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
    """Let the recorder take all that was published: it answers after what came before the question."""
    for node in cast.nodes:
        for writer in node.publishers:
            writer.wait_for_all_acked(DRAIN)
    _ask(cast, f"{RECORDER}/{DRAINED}")


def _ask(cast: _Cast, service: str) -> None:
    client = cast.watcher.create_client(Trigger, service)
    cast.wait(client.service_is_ready, WIRE_S, f"the service {service} does not answer")
    future = client.call_async(Trigger.Request())
    cast.wait(future.done, WIRE_S, f"the service {service} does not answer")
