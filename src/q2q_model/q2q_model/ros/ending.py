"""Tell a call that failed because ROS was just shut down from one that failed for a reason."""

from collections.abc import Iterator
from contextlib import contextmanager

from rclpy._rclpy_pybind11 import InvalidHandle, RCLError
from rclpy.node import Node


@contextmanager
def forgiving_the_end(node: Node) -> Iterator[None]:
    """Let a publish fail silently where a signal has shut ROS down in the middle of a callback."""
    try:
        yield
    except (RCLError, InvalidHandle):
        if node.context.ok():
            raise
