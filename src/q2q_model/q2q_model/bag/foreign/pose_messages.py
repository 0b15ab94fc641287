"""Poses in messages of other software, one row each.

Message definitions come from the bag, which allows any version of a type; a bag without definitions is read
as ROS 2 Jazzy.
"""

from collections.abc import Callable, Iterator, Sequence
from operator import attrgetter

import numpy as np
from rosbags.typesys import Stores, get_typestore
from rosbags.typesys.store import Typestore

from q2q_model.bag.foreign.topic_map import TopicMap
from q2q_model.bag.storage.definitions import jazzy_types, naming_message
from q2q_model.bag.storage.errors import BagError
from q2q_model.bag.storage.own_definition import own_types
from q2q_model.bag.storage.source import Channel, RawMessage, Source
from q2q_model.signals.stamps import stamp_from_parts, time_from_stamp

POSES = {
    "PoseStamped": ("pose.position", "pose.orientation"),
    "PoseWithCovarianceStamped": ("pose.pose.position", "pose.pose.orientation"),
    "Odometry": ("pose.pose.position", "pose.pose.orientation"),
    "TransformStamped": ("transform.translation", "transform.rotation"),
}
"""Type name without package -> attributes of position and quaternion."""
NAMED = ("NamedPoseArray", "NamedPoseArrayV2")
"""Types of motion_capture_tracking_interfaces with all vehicles in one message."""
FULL_STATE = "FullState"
"""Reference of crazyflie_interfaces: pose, twist and acceleration, all in the world."""
SETPOINTS = POSES | {FULL_STATE: ("pose.position", "pose.orientation")}
"""The same of references."""
POSITION = "Position"
"""Reference of crazyflie_interfaces: x, y, z and yaw."""
NO_QUAT = (np.nan,) * 4
"""Quaternion of a Position: its yaw is in radians or degrees, and a reference needs none."""
NO_RATES = (np.nan,) * 6
"""Velocity and acceleration of a message that carries none."""
_XYZ, _XYZW = attrgetter("x", "y", "z"), attrgetter("x", "y", "z", "w")

Row = tuple[float, ...]
"""t, x y z, qx qy qz qw and, of references, velocity and acceleration; without t what a message holds."""


def message_poses(
    source: Source, channel: Channel, topic_map: TopicMap, known: Sequence[str]
) -> Iterator[list[tuple[str, Row]]]:
    """Yield the poses of each message of a known type: name (empty for a topic of one vehicle) and row."""
    kind = channel.type_name.rsplit("/", 1)[-1]
    if kind not in known:
        hint = f"; {kind} is read under poses" if kind in NAMED else ""
        raise BagError(
            f"topic {channel.topic} holds {channel.type_name}, which cannot be read here; must be one of "
            f"{', '.join(known)}{hint}"
        )
    decode = _decoder(source, channel)
    for message in source.read({channel.topic}):
        with naming_message(source.path, message, channel.type_name):
            value = decode(message)
            t = time_from_stamp(_stamp_ns(value) if topic_map.by_header else message.stamp_ns)
            found: list[tuple[str, Row]] = [(name, (t, *row)) for name, row in _placed(value, kind)]
        yield found


def _stamp_ns(value: object) -> int:
    sec, nanosec = attrgetter("header.stamp.sec", "header.stamp.nanosec")(value)
    return stamp_from_parts(sec, nanosec)


def _placed(value: object, kind: str) -> list[tuple[str, Row]]:
    """Return name, and position, quaternion, velocity and acceleration, of every pose of a message."""
    if kind == POSITION:
        return [("", (*_XYZ(value), *NO_QUAT, *NO_RATES))]
    rates: Row = NO_RATES
    if kind in SETPOINTS:
        poses = [("", *attrgetter(*SETPOINTS[kind])(value))]
    else:
        named = attrgetter("name", "pose.position", "pose.orientation")
        poses = [named(pose) for pose in attrgetter("poses")(value)]
    if kind == FULL_STATE:
        vel, acc = attrgetter("twist.linear", "acc")(value)
        rates = (*_XYZ(vel), *_XYZ(acc))
    return [(name, (*_XYZ(at), *_XYZW(turn), *rates)) for name, at, turn in poses]


def _decoder(source: Source, channel: Channel) -> Callable[[RawMessage], object]:
    store = _own_types(source, channel) if channel.definition else jazzy_types()
    if channel.type_name not in store.fielddefs:
        raise BagError(
            f"bag {source.path} has no definition of {channel.type_name}, which is not a common type"
        )
    read = store.deserialize_ros1 if source.ros1 else store.deserialize_cdr
    return lambda message: read(message.data, message.type_name)


def _own_types(source: Source, channel: Channel) -> Typestore:
    """Return the types that the bag defines for a channel, which may differ from those of Jazzy."""
    store = get_typestore(Stores.EMPTY)
    store.register(own_types(source.path, channel.type_name, channel.definition))
    return store
