"""Of a vehicle that motion capture names twice in one message no pose is taken; the others are."""

import math
import sys

import pytest

pytest.importorskip("q2q_msgs", reason="the workspace is not built")

from room_node import RoomNode

from q2q_control.crazyswarm.message_conversion import NamedPose
from q2q_control.ros.crazyswarm_bridge import Crazyswarm
from q2q_control.ros.crazyswarm_types import find_pose_types
from q2q_model.ros.topics.messages import header_at
from q2q_model.signals.cdr.cdr_reader import decode
from q2q_model.signals.values import MocapFrame
from q2q_sim.ros.absent_packages import interface_packages

TOLD = "refused: /poses: cf1 given twice: ignored, as either pose may be another vehicle's; check its markers"


def test_the_duplicate_vehicle_alone_is_left_out_and_told_once(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, module in interface_packages().items():
        monkeypatch.setitem(sys.modules, name, module)
    node = RoomNode("crazyswarm", {"vehicles": ("cf1", "cf2")}, {})
    Crazyswarm(node)
    places = ("cf1", 1.0), ("cf2", 2.0), ("wand", 3.0), ("cf1", 4.0), ("wand", 5.0)
    poses = [NamedPose(name, (x, 0.0, 0.0), (math.nan,) * 4) for name, x in places]
    for k in range(2):
        node.takers["/poses"](find_pose_types().write(header_at(k * 10_000_000), poses))
        frame = decode(node.published["mocap"][-1], MocapFrame)
        assert (frame.names, frame.pos[:, 0].tolist()) == (("cf2",), [2.0])
        node.report()
        assert node.graded[1] == TOLD
    assert node.lines.count(TOLD) == 1
