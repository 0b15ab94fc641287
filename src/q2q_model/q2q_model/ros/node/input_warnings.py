"""Warnings of input that is of no use to a node: unknown names, standing stamps, several writers."""

from collections.abc import Callable, Iterable

from rclpy.node import Node

from q2q_model.node.health import Health
from q2q_model.signals.layout import Signal
from q2q_model.signals.values import Names

FRAMES = 100
"""Frames with one stamp after which is warned; a lost message is requested again a few times."""

Take = Callable[[int, Signal], None]


def warn_of_unknown_names(node: Node, topic: str, vehicles: Names) -> Take:
    """Return a listener that warns of names in a topic that are not among `vehicles`; none are all."""

    def unknown(names: Names) -> Names:
        return tuple(sorted(set(names) - set(vehicles))) if vehicles else ()

    return _warn_once(node, topic, unknown, lambda _: f"ignored: vehicles are {', '.join(vehicles)}")


def warn_of_missing_names(node: Node, topic: str, vehicles: Names) -> Take:
    """Return a listener that warns of `vehicles` that a topic does not have."""

    def missing(names: Names) -> Names:
        return tuple(sorted(set(vehicles) - set(names)))

    return _warn_once(node, topic, missing, lambda names: f"missing: it has {', '.join(names) or 'none'}")


def _warn_once(node: Node, topic: str, differ: Callable[[Names], Names], why: Callable[[Names], str]) -> Take:
    told: set[Names] = {()}
    last: Names | None = None

    def look(_: int, signal: Signal) -> None:
        nonlocal last
        if signal.names is last:
            return
        last = signal.names
        different = differ(last)
        if different not in told:
            told.add(different)
            node.get_logger().warning(f"{topic}: {', '.join(different)} {why(last)}")

    return look


class AbsentNames:
    """Warning, once for the same names, of vehicles with a setpoint that a source of vehicles has not."""

    def __init__(self, node: Node, source: str, warning: str, health: Health | None = None) -> None:
        """Compare setpoints with a source once it is there: "cf7 not in source ..." is {} in the warning.

        A `health` has it too, as long as it is so.
        """
        self._node, self._source, self._warning, self._health = node, source, warning, health
        self._there: Names = ()
        self._asked: Names = ()
        self._told: set[Names] = {()}

    def take_source(self, names: Names) -> None:
        """Take the vehicles that the source has now."""
        if names != self._there:
            self._there = names
            self._compare()

    def look(self, _: int, setpoint: Signal) -> None:
        """Take a setpoint."""
        if setpoint.names != self._asked:
            self._asked = setpoint.names
            self._compare()

    def _compare(self) -> None:
        absent = tuple(sorted(set(self._asked) - set(self._there))) if self._there else ()
        told = f"{', '.join(absent)} not in {self._source}, which has {', '.join(self._there)}"
        if self._health is not None:
            self._health.doubts[f"{self._source}'s vehicles"] = told if absent else ""
        if absent not in self._told:
            self._told.add(absent)
            self._node.get_logger().warning(self._warning.format(told))


class StandingStamps:
    """Warning, once, that frames come with one and the same stamp."""

    def __init__(self, node: Node, topic: str) -> None:
        """Watch the stamps of a topic."""
        self._node, self._topic = node, topic
        self._stamp_ns, self._frames = -1, 0

    def look(self, stamp_ns: int, _: Signal) -> None:
        """Take the stamp of a message."""
        self._frames = self._frames + 1 if stamp_ns == self._stamp_ns else 0
        self._stamp_ns = stamp_ns
        if self._frames == FRAMES:
            told = f"{FRAMES} frames stamped {1e-9 * stamp_ns:g} s: stamp each with its time of capture"
            self._node.get_logger().warning(f"{self._topic}: {told}")


def writers_of(node: Node, topic: str) -> list[str]:
    """Return the names of the nodes that write a topic, sorted."""
    found = node.get_publishers_info_by_topic(node.resolve_topic_name(topic))
    return sorted(one.node_name for one in found)


def _full_names_of(node: Node, resolved: str) -> list[str]:
    """Return the names of the nodes that write a topic, with their namespaces, sorted."""
    found = node.get_publishers_info_by_topic(resolved)
    return sorted(f"{one.node_namespace}/{one.node_name}".strip("/") for one in found)


class SeveralWriters:
    """Warning, once for the same nodes, that too many nodes write a topic, or two of one name."""

    def __init__(self, node: Node, topic: str, most: float = 1) -> None:
        """Watch the writers of a topic, of which `most` are right, each of another name."""
        self._node, self.topic, self._most = node, topic, most
        self._told: set[str] = set()

    def look(self) -> str:
        """Return what is wrong with the writers now, empty if nothing is; warn of it the first time."""
        resolved = self._node.resolve_topic_name(self.topic)  # rclpy does not remap what it counts
        if self._node.count_publishers(resolved) <= 1:
            return ""
        writers = _full_names_of(self._node, resolved)
        namesakes, too_many = len({*writers}) < len(writers), len(writers) > self._most
        if not (namesakes or too_many):
            return ""
        may = f"{self._most} may" if too_many else "each must have a name and vehicles of its own"
        killed = "; one that was killed counts until DDS drops it" if namesakes else ""
        among = f"{len(writers)} nodes write it ({', '.join(writers)})"
        told = f"{self.topic}: {among}; {may}: stop the others{killed}"
        if told not in self._told:
            self._told.add(told)
            self._node.get_logger().warning(told)
        return told


class InputWriters:
    """Writers of the inputs of a node, or of its output, which a second such node would double."""

    def __init__(self, node: Node, topics: Iterable[str], health: Health, most: float = 1) -> None:
        """Watch the writers of some topics, of which `most` are right; `health` has what is wrong."""
        self._writers, self._health = [SeveralWriters(node, topic, most) for topic in topics], health

    def look(self) -> str:
        """Return what is wrong with the writers now, empty if nothing is; warn of it the first time."""
        found = {writers.topic: writers.look() for writers in self._writers}
        self._health.doubts |= found
        return "; ".join(filter(None, found.values()))
