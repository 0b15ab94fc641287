"""Process of one or more nodes: start, spin, clean shutdown, one-line errors.

SIGINT, SIGTERM and SIGHUP (of a closed terminal) are handled here: rclpy would shut ROS down in the middle of
a callback, and Python would raise KeyboardInterrupt anywhere, e.g. while llvmlite frees memory, which is then
freed twice. A first signal lets the running callback, or the building of nodes, complete; a second one while
they are built ends at once. An ignored SIGHUP (nohup) remains ignored.
"""

import gc
import os
import signal
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from time import monotonic
from types import FrameType
from typing import TypeVar
from weakref import WeakSet

import rclpy
from rclpy.duration import Duration
from rclpy.exceptions import InvalidParameterTypeException, NameValidationException
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from q2q_model.compilation.compilation_notice import give_notice_of_compilation
from q2q_model.node.log_folder import provide_log_folder
from q2q_model.node.loopback import restrict
from q2q_model.node.ros_refusal import refusal_of_ros
from q2q_model.ros.node.bounded_spin import BoundedSpin
from q2q_model.ros.node.node_parameters import name_undeclared, refuse_undeclared
from q2q_model.ros.node.ready import offer_drained, offer_ready

LEAVE_S = 20
"""Timeout of the ROS shutdown [s]: Fast DDS 2.14 can deadlock when others leave at the same moment."""
HAND_OVER = Duration(seconds=2.0)
"""Longest wait of a finished node for the subscribers of one topic."""
ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

Kept = TypeVar("Kept")


class NodeFailedError(RuntimeError):
    """Error in a callback that ends the node, as in lockstep, where all others would wait for its output."""


REFUSALS = (ValueError, OSError, NameValidationException, InvalidParameterTypeException, NodeFailedError)
"""Errors that end the process with one line and status 2."""
_FINISHED: WeakSet[Node] = WeakSet()


def run(
    name: str,
    build: Callable[[Node], Kept],
    end: Callable[[Kept], None] | None = None,
    land: Callable[[Kept], float] | None = None,
) -> None:
    """Run a node until SIGINT, SIGTERM or SIGHUP; exit 0 then, 2 on an error of the node.

    Such errors are an invalid parameter or input file, and NodeFailedError.

    Args:
        name: name of the node.
        build: declares parameters, subscribes and publishes; its result is kept alive.
        end: called with that result once the node has stopped, e.g. to close files.
        land: called with that result on a signal or an error, then again and again: lands what flies, and
            returns how long that takes [s]; callbacks run on until it is 0, or for the first such time.
    """

    def alone() -> dict[Node, Kept]:
        return {(node := Node(name)): build(node)}

    run_together(name, alone, end, land)


def run_together(
    name: str,
    build: Callable[[], Mapping[Node, Kept]],
    end: Callable[[Kept], None] | None = None,
    land: Callable[[Kept], float] | None = None,
) -> None:
    """Run several nodes in one process, as `run` does; `name` prefixes notices and error messages."""
    ending = _Ending()
    give_notice_of_compilation(name)
    gc.disable()  # objects created during start-up are never freed
    try:
        start_ros()
        kept = build()
        refuse_undeclared(kept)
        for node in kept:
            name_undeclared(node)
            offer_ready(node)
            offer_drained(node)
            node.get_logger().info("running")
        try:
            _spin_and_land(kept, ending, land)
        finally:
            if end is not None:
                for one in kept.values():
                    end(one)
    except REFUSALS as refusal:
        for number in ENDING:
            signal.signal(number, signal.SIG_IGN)  # it is ending; an interrupt must not replace the status
        print(f"{name}: {_in_one_line(refusal)}", file=sys.stderr)
        sys.exit(2)
    except ExternalShutdownException:
        pass
    finally:
        _leave()


def _in_one_line(refusal: Exception) -> str:
    """Return an error's text, without what rclpy adds to it."""
    text = str(refusal)
    if isinstance(refusal, NameValidationException):  # a line with a mark below the name
        return " ".join(text.rstrip("^ \n").split())
    if isinstance(refusal, InvalidParameterTypeException):  # the name again; rclpy's own parameters are bool
        return f"{text.rpartition(': ')[0]}; give true or false"
    return text


def start_ros(arguments: Sequence[str] | None = None) -> None:
    """Start ROS without signal handlers, on loopback if it is to stay on this machine.

    Args:
        arguments: command line; None takes the process's own.

    Raises:
        ValueError: ROS does not understand them.
    """
    restrict(os.environ)
    provide_log_folder(os.environ)
    words = None if arguments is None else list(arguments)
    try:
        rclpy.init(args=words, signal_handler_options=SignalHandlerOptions.NO)
    except RuntimeError as error:  # of rcl, whose classes rclpy does not export
        raise ValueError(refusal_of_ros(error)) from error


def _leave() -> None:
    """Shut ROS down."""
    _bound_leaving()
    rclpy.try_shutdown()


def _bound_leaving() -> None:
    """Let SIGALRM end the process if the middleware does not return within LEAVE_S."""
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.alarm(LEAVE_S)


class _Ending:
    """Flag that the end was requested."""

    def __init__(self) -> None:
        self.requested, self.building = False, True
        for number in ENDING:
            if number is not signal.SIGHUP or signal.getsignal(number) is not signal.SIG_IGN:
                signal.signal(number, self._ask)

    def _ask(self, _: int, __: FrameType | None) -> None:
        if self.requested and self.building:
            os._exit(0)  # nothing needs cleaning up yet
        self.requested = True


def _spin_and_land(kept: Mapping[Node, Kept], ending: _Ending, land: Callable[[Kept], float] | None) -> None:
    """Run callbacks until the end, and on until nothing lands any more."""
    spin = BoundedSpin(kept)
    try:
        _spin(spin, kept, ending)
    finally:
        if land is not None:
            latest = monotonic() + max(map(land, kept.values()), default=0.0)
            while rclpy.ok() and monotonic() < latest and any(land(one) > 0.0 for one in kept.values()):
                spin()


def _spin(spin: BoundedSpin, nodes: Iterable[Node], ending: _Ending) -> None:
    """Run the callbacks of the nodes until a signal arrives or ROS shuts down."""
    ending.building = False
    gc.freeze()  # exclude the objects created so far from collection in flight
    gc.enable()
    while rclpy.ok() and not ending.requested:
        spin()
        if any(node in _FINISHED for node in nodes):
            _hand_over(nodes)
            _bound_leaving()
            for node in nodes:
                spin.executor.remove_node(node)
                node.destroy_node()  # informs the others, who would wait 20 s for its acknowledgements
            return


def finish(node: Node) -> None:
    """End the process of a finished node once its messages are acknowledged."""
    _FINISHED.add(node)


def _hand_over(nodes: Iterable[Node]) -> None:
    """Wait until subscribers have acknowledged the nodes' messages, at most HAND_OVER per topic."""
    for node in nodes:
        for writer in node.publishers:
            writer.wait_for_all_acked(HAND_OVER)
