"""No flight by the bridge begins without the poses of its vehicles, or with those of two drivers."""

import math
import sys
from collections.abc import Callable

import pytest

pytest.importorskip("q2q_msgs", reason="the workspace is not built")

from rclpy.duration import Duration
from rclpy.qos import QoSProfile
from room_node import Reader, RoomNode

from q2q_control.crazyswarm.message_conversion import NamedPose
from q2q_control.ros.crazyswarm_bridge import POSES_OUT, Crazyswarm
from q2q_control.ros.crazyswarm_types import find_pose_types
from q2q_model.diagnostics.health import Level
from q2q_model.ros.topics.messages import header_at
from q2q_sim.ros.absent_packages import interface_packages

CALLS = ("take_off", "fly", "start")


@pytest.fixture
def room(monkeypatch: pytest.MonkeyPatch) -> RoomNode:
    """Return a room with a bridge that flies two vehicles by filtered poses."""
    for name, module in interface_packages().items():
        monkeypatch.setitem(sys.modules, name, module)
    node = RoomNode("crazyswarm", {"vehicles": ("cf1", "cf2"), "poses_out": "/poses_filtered"}, {})
    Crazyswarm(node)
    return node


def take_poses(node: RoomNode, *names: str) -> None:
    """Let motion capture publish poses of bodies of some names."""
    poses = [NamedPose(name, (0.0, 0.0, 0.0), (math.nan,) * 4) for name in names]
    node.takers["/poses"](find_pose_types().write(header_at(0), poses))


def is_told_until_it_is_mended(node: RoomNode, message: str, mend: Callable[[], None]) -> None:
    """Check that a message is the answer to what begins a flight, and in diagnostics, until it is mended."""
    assert [node.answer(call) for call in CALLS] == [message] * 3
    node.report()
    assert node.graded == (Level.WARN, message)
    mend()
    assert message not in {node.answer(call) for call in CALLS}
    node.report()
    assert node.graded[0] != Level.WARN


def test_two_drivers_of_motion_capture_are_named(room: RoomNode) -> None:
    room.writers = {"/poses": ("motion_capture_tracking", "old_tracking")}
    message = "/poses: 2 nodes write it (motion_capture_tracking, old_tracking); 1 may: stop the others"
    is_told_until_it_is_mended(room, message, room.writers.clear)
    assert room.lines.count(message) == 1


def test_names_that_motion_capture_has_in_place_of_vehicles_are_told(room: RoomNode) -> None:
    take_poses(room, "CF1", "CF2")
    advice = "name the bodies in motion capture like the vehicles"
    message = f"/poses has CF1, CF2, none of cf1, cf2: {advice}"
    is_told_until_it_is_mended(room, message, lambda: take_poses(room, "cf2", "cf1", "wand"))
    take_poses(room, "CF1", "CF2")  # vehicles that were there are lost, not misnamed
    assert message not in room.answer("take_off")
    assert [line for line in room.lines if advice in line] == [message]


def test_of_one_misnamed_vehicle_only_its_names_are_told(room: RoomNode) -> None:
    take_poses(room)
    assert "/poses has" not in room.answer("take_off")
    take_poses(room, "cf1", "CF2")
    assert room.answer("take_off").startswith("/poses has CF2, none of cf2: ")


def test_a_server_that_does_not_read_the_filtered_poses_is_told(room: RoomNode) -> None:
    readers, room.pose_readers = room.pose_readers, []
    is_told_until_it_is_mended(
        room,
        "no node reads /poses_filtered: start Crazyswarm2's server with its topic poses remapped to "
        "/poses_filtered",
        lambda: room.pose_readers.extend(readers),
    )


def test_a_reader_that_requests_no_deadline_gets_every_pose(room: RoomNode) -> None:
    room.pose_readers = [Reader("crazyflie_server", QoSProfile(depth=1))]
    assert QoSProfile(depth=1).deadline.nanoseconds == 0
    assert "no pose of" not in room.answer("take_off")


def test_a_server_that_requests_a_shorter_deadline_than_is_offered_is_told(room: RoomNode) -> None:
    """DDS does not connect the two; a recorder that reads the same topic is no server."""
    fast = QoSProfile(depth=1, deadline=Duration(nanoseconds=5_000_000))  # poses_qos_deadline: 200.0
    room.pose_readers = [Reader("rosbag2_recorder", QoSProfile(depth=1, deadline=Duration(seconds=1e9))),
                         Reader("crazyflie_server", fast)]  # fmt: skip
    is_told_until_it_is_mended(
        room,
        "no pose of /poses_filtered reaches crazyflie_server, which requires a deadline of 5 ms: 10 ms is "
        "offered; set poses_qos_deadline in server.yaml to 100 Hz or less",
        lambda: room.pose_readers.__setitem__(1, Reader("crazyflie_server", POSES_OUT)),
    )
