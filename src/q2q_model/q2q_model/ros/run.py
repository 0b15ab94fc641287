"""Run one node as a process: start, spin, end cleanly, and say what is wrong in one line."""

import sys
from collections.abc import Callable

import rclpy
from rclpy.executors import Executor, ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node

from q2q_model.ros.ready import offer_ready

WAKE_S = 0.5
"""How often the spin loop looks whether it should end [s]. (EventsExecutor.spin() runs nothing here.)"""

Build = Callable[[Node], object]
"""Builds a block's node: declares parameters, subscribes, publishes. What it returns is kept alive."""


def run(name: str, build: Build) -> None:
    """Run a node until SIGINT or SIGTERM; exit 0 then, 2 on a wrong parameter or input file."""
    rclpy.init()
    node = Node(name)
    try:
        kept = build(node)
        offer_ready(node)
        spin(node)
        del kept
    except (ValueError, OSError) as refusal:
        print(f"{name}: {refusal}", file=sys.stderr)
        sys.exit(2)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()


def spin(*nodes: Node) -> None:
    """Run the callbacks of the nodes until ROS is shut down."""
    executor = make_executor()
    for node in nodes:
        executor.add_node(node)
    while rclpy.ok():
        executor.spin_once(timeout_sec=WAKE_S)


def make_executor() -> Executor:
    """Return the events executor where present (3 times less CPU), else the plain one."""
    try:
        from rclpy.experimental import EventsExecutor
    except ImportError:
        return SingleThreadedExecutor()
    return EventsExecutor()
