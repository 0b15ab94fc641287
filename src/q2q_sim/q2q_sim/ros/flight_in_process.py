"""Flights of scenarios through the nodes within this process.

    parameter file -> start ROS -> nodes of `ros2 run q2q_sim stack` on one executor -> connect -> fly -> end

ROS and every node are created again for each flight, so that only loaded code remains from the one before.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import rclpy
from rclpy.executors import Executor
from rclpy.node import Node

from q2q_model.ros.node.bounded_spin import make_executor
from q2q_model.ros.node.ready import offer_drained, offer_ready
from q2q_model.ros.node.run import start_ros
from q2q_sim.ros import stack
from q2q_sim.ros.flight_director import START_S, FlightDirector
from q2q_sim.simulator.flight_clock import FlightTiming

SIMULATOR = "simulator"


def fly_in_process(parameters: Path) -> FlightTiming:
    """Fly a parameter file with a section for each node; return the wall-clock timing.

    Raises:
        ValueError: a node refuses a parameter.
        TimeoutError: the nodes do not connect, or the flight stalls.
    """
    start_ros(["--ros-args", "--params-file", str(parameters)])
    executor = make_executor()
    try:
        with _nodes(executor) as nodes, FlightDirector(lambda: None, executor) as director:
            names = [node.get_name() for node in nodes]
            director.wait_connected(names, START_S)
            director.start(SIMULATOR)
            timing = director.wait_summary(lambda _: None)
            director.wait_drained(names)
        return timing
    finally:
        executor.shutdown()
        rclpy.try_shutdown()


@contextmanager
def _nodes(executor: Executor) -> Iterator[list[Node]]:
    """Yield the nodes of a flight in the order of their parameter `nodes`; on exit close the bag."""
    kept = stack.build()
    try:
        for node in kept:
            offer_ready(node)
            offer_drained(node)
            executor.add_node(node)
        yield list(kept)
        for node in kept:
            executor.remove_node(node)
            node.destroy_node()
    finally:
        for made in kept.values():
            stack.close_node(made)
