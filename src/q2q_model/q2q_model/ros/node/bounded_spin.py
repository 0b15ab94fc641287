"""Executor of a process's nodes, and spins of it that return in time."""

from collections.abc import Collection

from rclpy.executors import Executor, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.task import Future

from q2q_model.ros.node.steady_timer import steady_timer

WAKE_S = 0.1
"""Longest spin, besides the callback that runs at its end [s].

EventsExecutor.spin() does not return on our signals, and spin_once per message costs more than the message.
"""


class BoundedSpin:
    """Spin of nodes that returns after WAKE_S, whatever is due.

    EventsExecutor checks its own timeout only while no callback is due. Where a timer's callback takes longer
    than its period one always is, so a timer ends the spin, which the executor calls in its turn.
    """

    def __init__(self, nodes: Collection[Node]) -> None:
        """Add the nodes to a new executor; one of them gets the timer."""
        self.executor = make_executor()
        self._end: Future[None] = Future()
        steady_timer(next(iter(nodes)), WAKE_S, lambda: self._end.set_result(None))
        for node in nodes:
            self.executor.add_node(node)

    def __call__(self) -> None:
        """Run callbacks for WAKE_S."""
        self._end = Future()  # a new one: the executor adds a callback to it each time
        self.executor.spin_until_future_complete(self._end, WAKE_S)


def make_executor() -> Executor:
    """Return the events executor if available (a third of the CPU time), else the single-threaded one."""
    try:
        from rclpy.experimental import EventsExecutor
    except ImportError:
        return SingleThreadedExecutor()
    return EventsExecutor()
