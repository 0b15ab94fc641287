"""Name the node that shares its process, and a bus, with others."""

from rclpy.node import Node

from q2q_model.signals.local_bus import LocalBus


class BusNode(Node):  # type: ignore[misc]  # rclpy has no types
    """A node whose wiring reads from a bus what is written within the process."""

    def __init__(self, name: str, bus: LocalBus) -> None:
        super().__init__(name)
        self.bus = bus
