"""Node that shares its process and a local bus with others."""

from rclpy.node import Node

from q2q_model.signals.local_bus import LocalBus


class BusNode(Node):  # type: ignore[misc]  # rclpy has no types
    """Node that receives topics published within its process from a local bus."""

    def __init__(self, name: str, bus: LocalBus) -> None:
        super().__init__(name)
        self.bus = bus


def bus_of(node: Node) -> LocalBus:
    """Return the bus of a node; one of its own if it shares none."""
    return node.bus if isinstance(node, BusNode) else LocalBus(())
