"""Publish `<name>/cmd_vel_legacy` as Crazyswarm2 takes it; the units are made in q2q_control.legacy."""

from geometry_msgs.msg import Twist, Vector3
from rclpy.node import Node
from rclpy.publisher import Publisher

from q2q_control.legacy import LegacyScale, legacy_setpoints
from q2q_model.decimation import Decimation
from q2q_model.signals import SwarmCommand

QUEUE = 10


class LegacyTopics:
    """Hold the publishers of every vehicle, made when it first appears."""

    def __init__(self, node: Node, scale: LegacyScale, rate_hz: float) -> None:
        self._node = node
        self._scale = scale
        self._due = Decimation(rate_hz)
        self._publishers: dict[str, Publisher] = {}

    def publish(self, _: int, command: SwarmCommand) -> None:
        """Publish every vehicle's command, at most `rate_hz` times a second."""
        if not self._due(command.t):
            return
        for name, row in zip(command.names, legacy_setpoints(command, self._scale).tolist(), strict=True):
            writer = self._of(name)
            if writer.get_subscription_count():
                pitch, roll, yaw_rate, pwm = row
                twist = Twist(linear=Vector3(x=pitch, y=roll, z=pwm), angular=Vector3(z=yaw_rate))
                writer.publish(twist)

    def _of(self, name: str) -> Publisher:
        if name not in self._publishers:
            self._publishers[name] = self._node.create_publisher(Twist, f"{name}/cmd_vel_legacy", QUEUE)
        return self._publishers[name]
