"""Run one node as a process: start, spin, end cleanly, and say what is wrong in one line.

SIGINT and SIGTERM are ours, not rclpy's, which shuts ROS down in the middle of a callback: while nodes are
built they interrupt; once nodes spin, the callback that runs is ended first. An interrupt that foreign code
swallows is still an end that was asked for.
"""

import gc
import signal
import sys
from collections.abc import Callable, Iterable, Mapping
from types import FrameType
from typing import TypeVar
from weakref import WeakSet

import rclpy
from rclpy.duration import Duration
from rclpy.executors import Executor, ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future

from q2q_model.ros.node.node_parameters import refuse_undeclared
from q2q_model.ros.node.ready import offer_drained, offer_ready

LEAVE_S = 20
"""Longest time to leave ROS [s]: Fast DDS 2.14 can lock up where others leave at the same moment."""
WAKE_S = 0.1
"""How often the spin loop looks whether it should end [s].

EventsExecutor.spin() runs nothing here, and a spin_once for each message costs more than the message.
"""

HAND_OVER = Duration(seconds=2.0)
"""How long a node that has finished waits for the readers of one topic."""
ENDING = (signal.SIGINT, signal.SIGTERM)

Kept = TypeVar("Kept")


_FINISHED: WeakSet[Node] = WeakSet()


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
    ending = _Ending()
    gc.disable()  # what is built and loaded stays
    try:
        rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
        kept = build()
        refuse_undeclared(kept)
        for node in kept:
            offer_ready(node)
            offer_drained(node)
        try:
            _spin(kept, ending)
        finally:
            if end is not None:
                for one in kept.values():
                    end(one)
    except (ValueError, OSError) as refusal:
        print(f"{name}: {refusal}", file=sys.stderr)
        sys.exit(2)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        _leave()


def _leave() -> None:
    """Shut ROS down; end this process by SIGALRM where its middleware does not let it go within LEAVE_S."""
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.alarm(LEAVE_S)
    rclpy.try_shutdown()


class _Ending:
    """Flag that the end was requested."""

    def __init__(self) -> None:
        self.asked, self.interrupts = False, True
        for number in ENDING:
            signal.signal(number, self._ask)

    def _ask(self, _: int, __: FrameType | None) -> None:
        self.asked = True
        if self.interrupts:
            raise KeyboardInterrupt


def _spin(nodes: Iterable[Node], ending: _Ending) -> None:
    """Run the callbacks of the nodes until the end is asked for, or ROS is shut down."""
    executor = make_executor()
    for node in nodes:
        executor.add_node(node)
    ending.interrupts = False
    gc.freeze()  # what stands now stays: the collector need not look at it again in flight
    gc.enable()
    while rclpy.ok() and not ending.asked:
        never: Future[None] = Future()  # a new one: the executor leaves a callback at it each time
        executor.spin_until_future_complete(never, WAKE_S)
        if any(node in _FINISHED for node in nodes):
            _hand_over(nodes)
            return


def finish(node: Node) -> None:
    """End the process of a node, whose work is done, once readers have acknowledged what it published."""
    _FINISHED.add(node)


def _hand_over(nodes: Iterable[Node]) -> None:
    """Give every reader the time to acknowledge what the nodes published."""
    for node in nodes:
        for writer in node.publishers:
            writer.wait_for_all_acked(HAND_OVER)


def make_executor() -> Executor:
    """Return the events executor where present (3 times less CPU), else the plain one."""
    try:
        from rclpy.experimental import EventsExecutor
    except ImportError:
        return SingleThreadedExecutor()
    return EventsExecutor()
