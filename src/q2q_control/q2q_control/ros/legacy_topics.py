"""Publishers of `<name>/cmd_vel_legacy`, in Crazyswarm2's units (q2q_control.radio.rpyt_scale)."""

from geometry_msgs.msg import Twist, Vector3
from rclpy.node import Node

from q2q_control.radio.rpyt_scale import LegacyScale, legacy_setpoints
from q2q_model.ros.topics.vehicle_publishers import VehiclePublishers
from q2q_model.signals.values import Names, SwarmCommand


class LegacyTopics:
    """Publishers of `cmd_vel_legacy`, one a vehicle."""

    def __init__(self, node: Node, scale: LegacyScale, rate_hz: float, names: Names) -> None:
        """Publish at most `rate_hz` times a second; `names` are the vehicles known in advance."""
        self._scale = scale
        self._writers = VehiclePublishers(node, {"cmd_vel_legacy": Twist}, rate_hz, names)

    def publish(self, _: int, command: SwarmCommand) -> None:
        """Publish the command of every vehicle, if one is due."""
        if not self._writers.due(command.t, command.names):
            return
        for name, row in zip(command.names, legacy_setpoints(command, self._scale).tolist(), strict=True):
            for writer in self._writers.read(name):
                pitch, roll, yaw_rate, pwm = row
                writer.publish(Twist(linear=Vector3(x=pitch, y=roll, z=pwm), angular=Vector3(z=yaw_rate)))
