"""Node that shares its process and a local bus with others."""

from rclpy.node import Node

from q2q_model.signals.local_bus import LocalBus


class BusNode(Node):  # type: ignore[misc]  # rclpy has no types
    """Node that receives topics published within its process from a local bus."""

    def __init__(self, name: str, bus: LocalBus) -> None:
        super().__init__(name)
        self.bus = bus
