"""Publishers of radio telemetry: `<name>/onboard_pose`, `<name>/battery`, `<name>/link_quality`.

`<name>/pose` is the mocap filter's; the onboard estimate has another name, so that both can be compared.
"""

import math
from time import monotonic

from geometry_msgs.msg import PoseStamped
from rclpy.node import Node
from sensor_msgs.msg import BatteryState
from std_msgs.msg import Float32, Header

from q2q_control.radio.link.vehicle_link import LinkHealth, OnboardPose
from q2q_model.node.connections import conflicting_nodes
from q2q_model.node.decimation import Decimation
from q2q_model.ros.topics.messages import pose_message
from q2q_model.signals.cdr.cdr_format import WORLD
from q2q_model.signals.values import Names

QUEUE = 10


class RadioTopics:
    """Telemetry publishers of all vehicles."""

    def __init__(self, node: Node, names: Names, rate_hz: float) -> None:
        self._node = node
        self._due = {name: Decimation(rate_hz) for name in names}
        self._poses = {
            name: node.create_publisher(PoseStamped, f"{name}/onboard_pose", QUEUE) for name in names
        }
        self._batteries = {
            name: node.create_publisher(BatteryState, f"{name}/battery", QUEUE) for name in names
        }
        self._qualities = {
            name: node.create_publisher(Float32, f"{name}/link_quality", QUEUE) for name in names
        }

    def publish(self, name: str, health: LinkHealth, pose: OnboardPose | None) -> None:
        """Publish a vehicle's telemetry, at most `rate_hz` times per second, while it is connected."""
        if not health.connected or not self._due[name](monotonic()):
            return
        header = Header(stamp=self._node.get_clock().now().to_msg(), frame_id=WORLD)
        if pose is not None:
            self._poses[name].publish(PoseStamped(header=header, pose=pose_message(pose.pos, pose.quat)))
        self._batteries[name].publish(BatteryState(header=header, voltage=health.volt, present=True))
        if not math.isnan(health.quality):
            self._qualities[name].publish(Float32(data=health.quality))

    def other_radios(self) -> str:
        """Return the names of other nodes that publish these vehicles' batteries; empty if there are none."""
        found = [self._node.get_publishers_info_by_topic(f"{name}/battery") for name in self._batteries]
        return conflicting_nodes(self._node.get_name(), [[one.node_name for one in some] for some in found])
