"""Tell a call that failed because ROS was just shut down from one that failed for a reason."""

from types import TracebackType

from rclpy._rclpy_pybind11 import InvalidHandle, RCLError
from rclpy.node import Node


class ForgivingTheEnd:
    """Let a publish fail silently where a signal has shut ROS down in the middle of a callback; a context."""

    def __init__(self, node: Node) -> None:
        self._context = node.context

    def __enter__(self) -> None:
        """Enter; any number of times."""

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> bool:
        """Return whether the error is forgiven."""
        return isinstance(error, RCLError | InvalidHandle) and not self._context.ok()
