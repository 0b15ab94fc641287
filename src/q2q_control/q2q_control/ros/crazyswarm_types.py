"""Message types of Crazyswarm2's optional interface packages, in both versions of its poses."""

from collections.abc import Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Protocol

from geometry_msgs.msg import Pose
from std_msgs.msg import Header

from q2q_control.crazyswarm.message_conversion import NamedPose
from q2q_model.ros.topics.messages import pose_message

MOCAP_PACKAGE, CRAZYFLIE_PACKAGE = "motion_capture_tracking_interfaces", "crazyflie_interfaces"


class PoseMessage(Protocol):
    """NamedPose: with a name or, before December 2021, with a header whose frame_id is the name."""

    name: str
    header: Header
    pose: Pose


class PosesMessage(Protocol):
    """NamedPoseArray."""

    header: Header
    poses: Sequence[PoseMessage]


@dataclass(frozen=True, slots=True)
class PoseTypes:
    """Message types of motion capture."""

    array: type
    one: type

    @property
    def named(self) -> bool:
        """Return whether a pose has the field `name`."""
        return "name" in self.one.get_fields_and_field_types()  # type: ignore[attr-defined]

    def read(self, message: PoseMessage) -> NamedPose:
        """Return one pose."""
        where, turn = message.pose.position, message.pose.orientation
        name = message.name if self.named else message.header.frame_id
        return NamedPose(name, (where.x, where.y, where.z), (turn.x, turn.y, turn.z, turn.w))

    def write(self, header: Header, poses: Sequence[NamedPose]) -> PosesMessage:
        """Return the message of some poses."""
        made: PosesMessage = self.array(header=header, poses=[self._one(header, pose) for pose in poses])
        return made

    def _one(self, header: Header, pose: NamedPose) -> PoseMessage:
        where = pose_message(pose.pos, pose.quat)
        own = Header(stamp=header.stamp, frame_id=pose.name)
        made: PoseMessage = (
            self.one(name=pose.name, pose=where) if self.named else self.one(header=own, pose=where)
        )
        return made


def find_types(package: str, names: Sequence[str], folder: str = "msg") -> list[type]:
    """Return types of a package; raise ImportError with what is missing and how to get it."""
    try:
        module = import_module(f"{package}.{folder}")
    except ImportError as missing:
        hint = f"sudo apt install ros-jazzy-{package.replace('_', '-')}"
        raise ImportError(f"{package} is not installed ({hint})") from missing
    absent = [name for name in names if name not in vars(module)]
    if absent:
        raise ImportError(f"{package} has no {', '.join(absent)}: update it")
    return [getattr(module, name) for name in names]


def find_pose_types(version: int = 1) -> PoseTypes:
    """Return the message types of motion capture; raise ImportError if they are missing.

    `version` is `topics.poses.version` of motion_capture.yaml; 2 is NamedPoseArrayV2, with latencies.
    """
    array, one = find_types(
        MOCAP_PACKAGE, ("NamedPoseArrayV2" if version == 2 else "NamedPoseArray", "NamedPose")
    )
    return PoseTypes(array, one)
