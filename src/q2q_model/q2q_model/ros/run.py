"""Run one node as a process: start, spin, end cleanly, and say what is wrong in one line."""

import gc
import sys
from collections.abc import Callable, Mapping
from typing import TypeVar

import rclpy
from rclpy._rclpy_pybind11 import InvalidHandle, RCLError
from rclpy.exceptions import NotInitializedException
from rclpy.executors import Executor, ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.task import Future

from q2q_model.ros.ready import offer_drained, offer_ready

WAKE_S = 0.5
"""How often the spin loop looks whether it should end [s].

EventsExecutor.spin() runs nothing here, and a spin_once for each message costs more than the message.
"""

Kept = TypeVar("Kept")


def run(name: str, build: Callable[[Node], Kept], end: Callable[[Kept], None] | None = None) -> None:
    """Run a node until SIGINT or SIGTERM; exit 0 then, 2 on a wrong parameter or input file.

    Args:
        name: the node's name.
        build: declares parameters, subscribes and publishes; what it returns is kept alive.
        end: called with that once the node has stopped, as to close files.
    """

    def alone() -> dict[Node, Kept]:
        return {(node := Node(name)): build(node)}

    run_together(name, alone, end)


def run_together(
    name: str, build: Callable[[], Mapping[Node, Kept]], end: Callable[[Kept], None] | None = None
) -> None:
    """Run several nodes in one process, as `run` does one; `name` speaks for all."""
    rclpy.init()
    try:
        kept = build()
        for node in kept:
            offer_ready(node)
            offer_drained(node)
        try:
            spin(*kept)
        finally:
            if end is not None:
                for one in kept.values():
                    end(one)
    except (ValueError, OSError) as refusal:
        print(f"{name}: {refusal}", file=sys.stderr)
        sys.exit(2)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except (RCLError, InvalidHandle, NotInitializedException):
        if rclpy.ok():  # else a signal ended ROS in the middle of a call: that is the end that was asked for
            raise
    finally:
        rclpy.try_shutdown()


def spin(*nodes: Node) -> None:
    """Run the callbacks of the nodes until ROS is shut down."""
    executor = make_executor()
    for node in nodes:
        executor.add_node(node)
    never: Future[None] = Future()
    gc.freeze()  # what stands now stays: the collector need not look at it again in flight
    while rclpy.ok():
        executor.spin_until_future_complete(never, WAKE_S)


def make_executor() -> Executor:
    """Return the events executor where present (3 times less CPU), else the plain one."""
    try:
        from rclpy.experimental import EventsExecutor
    except ImportError:
        return SingleThreadedExecutor()
    return EventsExecutor()
