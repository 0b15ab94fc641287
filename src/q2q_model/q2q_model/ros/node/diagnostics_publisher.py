"""Publication of a node's health on `/diagnostics` once per second, and of new trouble in its log."""

from collections.abc import Callable, Mapping
from copy import deepcopy
from time import monotonic

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node

from q2q_model.diagnostics.health import Health, HealthReport, health_report, tick_rate
from q2q_model.ros.node.steady_timer import steady_timer

MOST_WARNINGS = 20
"""Most warnings of one kind about a node's input, in the life of the node."""
PERIOD_S = 1.0
"""Period of the report [s]; the default of diagnostic_updater."""


def publish_health(
    node: Node, health: Health, facts: Callable[[], Mapping[str, str]] = dict[str, str]
) -> None:
    """Publish the node's health on `/diagnostics` every second of wall time, with the values of `facts`."""
    publisher = node.create_publisher(DiagnosticArray, "/diagnostics", 10)
    last, reported = [deepcopy(health)], [monotonic()]
    warned: set[str] = set()

    def publish() -> None:
        now = monotonic()
        rate = tick_rate(last[0], health, now - reported[0])
        reported[0] = now
        health.extra |= {"rate_hz": f"{rate:.1f}", **facts()}
        graded = health_report(last[0], health)
        if graded.trouble and graded.summary not in warned and len(warned) < MOST_WARNINGS:
            warned.add(graded.summary)
            node.get_logger().warning(graded.summary)
        message = DiagnosticArray(status=[_status(node.get_fully_qualified_name(), graded)])
        message.header.stamp = node.get_clock().now().to_msg()
        publisher.publish(message)
        last[0] = deepcopy(health)

    steady_timer(node, PERIOD_S, publish)


def _status(name: str, graded: HealthReport) -> DiagnosticStatus:
    return DiagnosticStatus(
        level=bytes([graded.level]),
        name=name,
        message=graded.summary,
        hardware_id="q2q",
        values=[KeyValue(key=key, value=value) for key, value in graded.values.items()],
    )
