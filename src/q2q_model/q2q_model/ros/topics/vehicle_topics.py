"""Each vehicle's state for other ROS software: `<name>/pose` and `<name>/odom`."""

import numpy as np
from geometry_msgs.msg import (
    Pose,
    PoseStamped,
    PoseWithCovariance,
    Twist,
    TwistWithCovariance,
    Vector3,
)
from nav_msgs.msg import Odometry
from rclpy.node import Node
from std_msgs.msg import Header

from q2q_model.geometry.rotations import level_where_unknown, rotate_inverse
from q2q_model.ros.topics.messages import header_at, pose_message
from q2q_model.ros.topics.vehicle_publishers import VehiclePublishers
from q2q_model.signals.repeated_stamp import StampOrder
from q2q_model.signals.values import LOST, Array, Names, SwarmState


class VehicleTopics:
    """Publishers of per-vehicle topics."""

    def __init__(self, node: Node, rate_hz: float, names: Names) -> None:
        """Publish at most at `rate_hz` [Hz]; `names` are the vehicles known before flight."""
        self._writers = VehiclePublishers(node, {"pose": PoseStamped, "odom": Odometry}, rate_hz, names)
        self._order = StampOrder()

    def publish(self, stamp_ns: int, state: SwarmState) -> None:
        """Publish pose and odometry of every vehicle that is not lost, at most `rate_hz` times per second.

        Nothing is published under a wrong stamp: software that takes these topics expects them to rise.
        """
        if self._order.reject_stamp(state.t) or not self._writers.due(state.t, stamp_ns, state.names):
            return
        quat = level_where_unknown(state.quat)
        vel_body = rotate_inverse(quat, state.vel)  # (n, 3), Odometry's child frame
        for row in np.flatnonzero(state.status != LOST):
            name = state.names[row]
            if not (publishers := self._writers.with_subscribers(name, stamp_ns)):
                continue
            pose, odom = publishers
            header = header_at(stamp_ns)
            where = pose_message(state.pos[row].tolist(), quat[row].tolist())
            pose.publish(PoseStamped(header=header, pose=where))
            odom.publish(_odometry(header, name, where, _twist(vel_body[row], state.ang_vel_body[row])))


def _twist(vel_body: Array, ang_vel_body: Array) -> Twist:
    vx, vy, vz = vel_body.tolist()
    p, q, r = ang_vel_body.tolist()
    return Twist(linear=Vector3(x=vx, y=vy, z=vz), angular=Vector3(x=p, y=q, z=r))


def _odometry(header: Header, name: str, pose: Pose, twist: Twist) -> Odometry:
    return Odometry(
        header=header,
        child_frame_id=name,
        pose=PoseWithCovariance(pose=pose),
        twist=TwistWithCovariance(twist=twist),
    )
