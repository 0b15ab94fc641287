"""Pose and odometry of each vehicle for other software: only of those that are or were just measured."""

import numpy as np
import pytest

pytest.importorskip("q2q_msgs", reason="the workspace is not built")

from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
from room_node import RoomNode

from q2q_model.geometry.rotations import identity_quat
from q2q_model.ros import mocap_filter_node
from q2q_model.signals.cdr.cdr_writer import encode
from q2q_model.signals.stamps import stamp_from_parts
from q2q_model.signals.values import MocapFrame


def test_a_vehicle_that_was_never_seen_or_is_lost_has_no_pose_and_one_that_is_missing_for_short_has() -> None:
    node = RoomNode("mocap_filter", {"vehicles": ("cf1", "cf2"), "vehicle_topics_hz": 1000.0}, {})
    mocap_filter_node.build(node)
    for k in range(100):
        pos = np.array([[1.0, 2.0, 0.01 * k if k < 50 else np.nan]])  # missing: it coasts for 0.35 s
        node.takers["mocap"](encode(MocapFrame(0.01 * k, ("cf1",), pos, identity_quat((1,))), 10**7 * k))
    poses, odometry = (node.published.get(f"cf1/{topic}", []) for topic in ("pose", "odom"))
    assert len(poses) == len(odometry) == 50 + 35
    pose, moved = poses[-1], odometry[-1]
    assert isinstance(pose, PoseStamped)
    assert isinstance(moved, Odometry)
    assert (pose.pose.position.x, pose.header.stamp.nanosec) == (pytest.approx(1.0), 840_000_000)
    assert moved.pose.pose == pose.pose
    assert node.published.get("cf2/pose", []) == []


def test_the_pose_of_a_vehicle_that_was_never_upright_is_level_as_that_of_a_lone_marker() -> None:
    node = RoomNode("mocap_filter", {"vehicles": ("cf1",), "vehicle_topics_hz": 1000.0}, {})
    mocap_filter_node.build(node)
    for k in range(20):
        frame = MocapFrame(
            0.01 * k, ("cf1",), np.array([[1.0, 2.0, 0.01 * k]]), np.array([[1.0, 0.0, 0.0, 0.0]])
        )
        node.takers["mocap"](encode(frame, 10**7 * k))
    pose, moved = (node.published[f"cf1/{topic}"][-1] for topic in ("pose", "odom"))
    assert isinstance(pose, PoseStamped)
    assert isinstance(moved, Odometry)
    quat, speed = pose.pose.orientation, moved.twist.twist.linear
    assert (quat.x, quat.y, quat.z, quat.w) == (0.0, 0.0, 0.0, 1.0)
    assert pose.pose.position.z == pytest.approx(0.19, abs=0.005)
    assert (speed.x, speed.y, speed.z) == pytest.approx((0.0, 0.0, 1.0), abs=0.1)


def test_no_pose_is_older_than_the_last_unless_the_clock_is_set_back_for_a_tenth_of_a_second() -> None:
    node = RoomNode("mocap_filter", {"vehicles": ("cf1",), "vehicle_topics_hz": 1000.0}, {})
    mocap_filter_node.build(node)
    wrong = {55: 1000.0, 77: -50.0, 88: -0.2}  # by how much [s]
    stamps = [round(1e9 * (100.0 + 0.01 * k + wrong.get(k, 0.0))) for k in range(100)]
    again = [10**7 * k for k in range(20)]  # a bag that is played once more
    for k, stamp_ns in enumerate([*stamps, *again]):
        pos = np.array([[1.0, 2.0, 0.01 * (k % 100)]])
        frame = MocapFrame(1e-9 * stamp_ns, ("cf1",), pos, identity_quat((1,)))
        node.takers["mocap"](encode(frame, stamp_ns))
    right = [stamp_ns for k, stamp_ns in enumerate(stamps) if k not in wrong]
    for topic in ("pose", "odom"):
        assert [_stamp_ns(message) for message in node.published[f"cf1/{topic}"]] == [*right, *again[10:]]


def _stamp_ns(message: object) -> int:
    assert isinstance(message, PoseStamped | Odometry)
    return stamp_from_parts(message.header.stamp.sec, message.header.stamp.nanosec)
