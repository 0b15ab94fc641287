"""Message class of each signal, message headers and their stamps, and poses."""

from collections.abc import Sequence

from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, Pose, Quaternion
from q2q_msgs import msg as q2q_msg
from std_msgs.msg import Header

from q2q_model.signals.cdr.cdr_format import WORLD
from q2q_model.signals.layout import LAYOUTS
from q2q_model.signals.stamps import stamp_from_parts, stamp_parts

MESSAGES: dict[type, type] = {signal: getattr(q2q_msg, layout.message) for signal, layout in LAYOUTS.items()}
"""Message class of each signal class."""


def header_at(stamp_ns: int) -> Header:
    """Return a header in the world frame with this stamp."""
    sec, nanosec = stamp_parts(stamp_ns)
    return Header(stamp=Time(sec=sec, nanosec=nanosec), frame_id=WORLD)


def stamp_of(header: Header) -> int:
    """Return the stamp of a header [ns]; raise ValueError if it is none."""
    return stamp_from_parts(header.stamp.sec, header.stamp.nanosec)


def pose_message(pos: Sequence[float], quat: Sequence[float]) -> Pose:
    """Return the message of a position x, y, z [m] and an orientation x, y, z, w."""
    x, y, z = pos
    qx, qy, qz, qw = quat
    return Pose(position=Point(x=x, y=y, z=z), orientation=Quaternion(x=qx, y=qy, z=qz, w=qw))
