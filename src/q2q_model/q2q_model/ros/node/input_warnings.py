"""Warnings of input that is of no use to a node: unknown names, stalled stamps.

Names that change for ever are reported MOST_WARNINGS times at most; missing vehicles as many more times as
there are vehicles, which may come one by one. Health has what AbsentNames finds for as long as it is so.
"""

from collections.abc import Callable

from rclpy.node import Node

from q2q_model.counted import listed
from q2q_model.diagnostics.health import Health
from q2q_model.ros.node.diagnostics_publisher import MOST_WARNINGS
from q2q_model.signals.layout import Signal
from q2q_model.signals.stamps import STALLED
from q2q_model.signals.values import Names
from q2q_model.signals.vehicle_name import LONGEST_SHOWN, is_printable_name

TakeSignal = Callable[[int, Signal], None]


def warn_of_unknown_names(node: Node, topic: str, vehicles: Names) -> TakeSignal:
    """Return a listener that warns of names in a topic that are not among `vehicles`; none are all."""

    def unknown(names: Names) -> Names:
        strangers = set(filter(is_printable_name, names)) - set(vehicles)
        return tuple(sorted(strangers)) if vehicles else ()

    why = f"ignored: the vehicles are {listed(vehicles)}"
    return _warn_once(node, topic, unknown, lambda _: why, MOST_WARNINGS)


def warn_of_unprintable_names(node: Node, topic: str) -> TakeSignal:
    """Return a listener that warns of names in a topic that are blank or have a line break."""

    def unprintable(names: Names) -> Names:
        return tuple(sorted({repr(name)[:LONGEST_SHOWN] for name in names if not is_printable_name(name)}))

    why = "ignored: name each object with characters that can be printed"
    return _warn_once(node, topic, unprintable, lambda _: why, MOST_WARNINGS)


def warn_of_missing_names(node: Node, topic: str, vehicles: Names) -> TakeSignal:
    """Return a listener that warns of `vehicles` that a topic does not have."""

    def missing(names: Names) -> Names:
        return tuple(sorted(set(vehicles) - set(names)))

    def why(names: Names) -> str:
        return f"missing: it has {listed(names) or 'none'}"

    return _warn_once(node, topic, missing, why, MOST_WARNINGS + len(vehicles))


def _warn_once(
    node: Node, topic: str, differ: Callable[[Names], Names], why: Callable[[Names], str], most: int
) -> TakeSignal:
    warned: set[Names] = {()}
    last: Names | None = None

    def warn(_: int, signal: Signal) -> None:
        nonlocal last
        if signal.names is last:
            return
        last = signal.names
        different = differ(last)
        if different not in warned and len(warned) <= most:
            warned.add(different)
            node.get_logger().warning(f"{topic}: {listed(different)} {why(last)}")

    return warn


class AbsentNames:
    """Warning, once for the same names, of vehicles with a setpoint that a source of vehicles has not."""

    def __init__(self, node: Node, source: str, warning: str, health: Health) -> None:
        """Compare setpoints with a source once it is there: "cf7 not in source ..." is {} in the warning.

        `health` has it too, as long as it is so.
        """
        self._node, self._source, self._warning, self._health = node, source, warning, health
        self._there: Names = ()
        self._asked: Names = ()
        self._warned: set[Names] = {()}

    def take_source(self, names: Names) -> None:
        """Take the vehicles that the source has now."""
        if names != self._there:
            self._there = names
            self._compare()

    def update(self, _: int, setpoint: Signal) -> None:
        """Take a setpoint."""
        if setpoint.names != self._asked:
            self._asked = setpoint.names
            self._compare()

    def _compare(self) -> None:
        absent = tuple(sorted(set(self._asked) - set(self._there))) if self._there else ()
        message = f"{listed(absent)} not in {self._source}, which has {listed(self._there)}"
        self._health.doubts[f"{self._source}'s vehicles"] = message if absent else ""
        if absent not in self._warned and len(self._warned) <= MOST_WARNINGS:
            self._warned.add(absent)
            self._node.get_logger().warning(self._warning.format(message))


class StalledStampWarning:
    """Warning, once, that frames come with one and the same stamp; `health` has it as long as they do."""

    def __init__(self, node: Node, topic: str, health: Health) -> None:
        """Watch the stamps of a topic."""
        self._node, self._topic, self._health = node, topic, health
        self._stamp_ns, self._frames = -1, 0

    def update(self, stamp_ns: int, _: Signal) -> None:
        """Take the stamp of a message."""
        self._frames = self._frames + 1 if stamp_ns == self._stamp_ns else 0
        self._stamp_ns = stamp_ns
        if self._frames == STALLED:
            found = f"{STALLED} frames stamped {1e-9 * stamp_ns:g} s: stamp each with its time of capture"
            self._doubt(f"{self._topic}: {found}")
            self._node.get_logger().warning(f"{self._topic}: {found}")
        elif not self._frames:
            self._doubt("")

    def _doubt(self, found: str) -> None:
        self._health.doubts[f"{self._topic} stamps"] = found
