"""Conflicting publishers of a node's topics: more of them than can be right are reported."""

from collections.abc import Iterable

from rclpy.node import Node

from q2q_model.counted import listed
from q2q_model.diagnostics.health import Health
from q2q_model.node.node_names import NAMELESS, full_node_names
from q2q_model.ros.node.diagnostics_publisher import MOST_WARNINGS


def publishers_of(node: Node, topic: str) -> list[str]:
    """Return the names of the nodes that publish a topic, with their namespaces, sorted.

    One that is being discovered, or has left, has no name yet or any more (NAMELESS).
    """
    found = node.get_publishers_info_by_topic(node.resolve_topic_name(topic))
    return full_node_names((one.node_namespace, one.node_name) for one in found)


class TopicConflict:
    """Warning, once for the same nodes, that too many nodes publish a topic, or two of one name."""

    def __init__(self, node: Node, topic: str, most: float = 1) -> None:
        """Watch the publishers of a topic, of which `most` are right, each of another name."""
        self._node, self.topic, self._most = node, topic, most
        self._warned: set[str] = set()

    def update(self) -> str:
        """Return what is wrong with the publishers now, empty if nothing is; warn of it the first time."""
        resolved = self._node.resolve_topic_name(self.topic)  # rclpy does not remap what it counts
        if self._node.count_publishers(resolved) <= 1:
            return ""
        writers = publishers_of(self._node, self.topic)
        named = [writer for writer in writers if writer != NAMELESS]
        namesakes, too_many = len({*named}) < len(named), len(writers) > self._most
        if not (namesakes or too_many):
            return ""
        may = f"{self._most} may" if too_many else "each needs its own name and vehicles"
        killed = "; one that was killed counts until DDS drops it" if namesakes else ""
        among = f"{len(writers)} nodes write it ({listed(writers)})"
        message = f"{self.topic}: {among}; {may}: stop the others{killed}"
        if message not in self._warned and len(self._warned) < MOST_WARNINGS:
            self._warned.add(message)
            self._node.get_logger().warning(message)
        return message


class PublisherConflicts:
    """Conflicting publishers of the inputs of a node, or of its output."""

    def __init__(self, node: Node, topics: Iterable[str], health: Health, most: float = 1) -> None:
        """Watch the publishers of some topics, of which `most` are right; `health` has what is wrong."""
        self._topics, self._health = [TopicConflict(node, topic, most) for topic in topics], health

    def update(self) -> str:
        """Return what is wrong with the publishers now, empty if nothing is; warn of it the first time."""
        found = {one.topic: one.update() for one in self._topics}
        self._health.doubts |= {f"{topic} writers": text for topic, text in found.items()}
        return "; ".join(filter(None, found.values()))
