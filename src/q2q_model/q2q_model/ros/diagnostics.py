"""Tell `/diagnostics` once a second how a node is doing."""

from copy import deepcopy

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node

from q2q_model.health import Health, HealthReport, report

PERIOD_S = 1.0
"""How often health is reported [s]; the custom of diagnostic_updater."""


def publish_health(node: Node, health: Health) -> None:
    """Publish the node's health on `/diagnostics` every second of wall time."""
    publisher = node.create_publisher(DiagnosticArray, "/diagnostics", 10)
    last = [deepcopy(health)]

    def tell() -> None:
        message = DiagnosticArray(status=[_status(node.get_fully_qualified_name(), report(last[0], health))])
        message.header.stamp = node.get_clock().now().to_msg()
        publisher.publish(message)
        last[0] = deepcopy(health)

    node.create_timer(PERIOD_S, tell)


def _status(name: str, graded: HealthReport) -> DiagnosticStatus:
    return DiagnosticStatus(
        level=bytes([graded.level]),
        name=name,
        message=graded.summary,
        hardware_id="q2q",
        values=[KeyValue(key=key, value=value) for key, value in graded.values.items()],
    )
