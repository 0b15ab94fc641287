"""Flights of scenarios through the nodes within this process.

    parameter file -> start ROS -> stack + simulator + recorder on one executor -> connect -> fly -> end

The nodes are those of `ros2 run q2q_sim stack`, with the simulator and the recorder; messages between
processes there pass through the middleware here, too. ROS and every node are created anew for each flight, so
that only loaded code remains from the one before.
"""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import rclpy
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from q2q_model.ros.node.ready import offer_drained, offer_ready
from q2q_model.ros.node.run import make_executor
from q2q_sim.loop.flight_clock import FlightTiming, timing_of
from q2q_sim.ros import stack
from q2q_sim.ros.bag_record_node import Recorder
from q2q_sim.ros.flight_director import FlightDirector
from q2q_sim.ros.simulator_node import Simulator

RECORDER, SIMULATOR = "bag_record", "simulator"
WIRE_S = 20.0
"""Time-out for connecting the nodes of one process [s]."""


def fly_here(parameters: Path) -> FlightTiming:
    """Fly a parameter file with a section for each node; return the wall-clock timing.

    Raises:
        ValueError: a node refuses a parameter.
        TimeoutError: the nodes do not connect, or the flight stalls.
    """
    rclpy.init(
        args=["--ros-args", "--params-file", str(parameters)], signal_handler_options=SignalHandlerOptions.NO
    )
    executor = make_executor()
    try:
        with _nodes(executor) as nodes, FlightDirector(lambda: None, executor) as director:
            names = [node.get_name() for node in nodes]
            director.wait_wired(names, WIRE_S)
            director.start(SIMULATOR)
            summary = director.wait_summary(lambda _: None)
            director.wait_drained(names)
        return timing_of(summary)
    finally:
        executor.shutdown()
        rclpy.try_shutdown()


@contextmanager
def _nodes(executor: Executor) -> Iterator[list[Node]]:
    """Yield the nodes of a flight, the recorder last; on exit close the bag."""
    own = Node(RECORDER)
    recorder = Recorder(own)
    try:
        chain: Mapping[Node, object] = stack.build()
        simulator = Node(SIMULATOR)
        kept = {**chain, simulator: Simulator(simulator), own: recorder}
        for node in kept:
            offer_ready(node)
            offer_drained(node)
            executor.add_node(node)
        yield list(kept)
        for node in kept:
            executor.remove_node(node)
            node.destroy_node()
    finally:
        recorder.close()
