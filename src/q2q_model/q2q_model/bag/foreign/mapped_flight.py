"""Flights in bags of other software: poses under any topic, assigned by a topic map.

Message definitions come from the bag, which allows any version of a type; a bag without definitions is read
as ROS 2 Jazzy.
"""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from operator import attrgetter
from pathlib import Path

import numpy as np
from rosbags.typesys import Stores, get_types_from_idl, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from q2q_model.bag.foreign.pose_frames import Poses, clock_set_back, pose_frames
from q2q_model.bag.foreign.references import References, with_references
from q2q_model.bag.foreign.topic_map import TopicMap
from q2q_model.bag.reader import SIGNALS
from q2q_model.bag.storage.definitions import jazzy_types
from q2q_model.bag.storage.errors import BagError, warn_of_repairs
from q2q_model.bag.storage.source import Channel, RawMessage, Source, flight_name, open_source
from q2q_model.flights.flight import Flight
from q2q_model.flights.joined_flight import flight_from_signals
from q2q_model.signals.cdr.cdr_format import BadMessageError
from q2q_model.signals.cdr.cdr_reader import SignalReader
from q2q_model.signals.layout import LAYOUTS, Signal
from q2q_model.signals.stamps import stamp_from_parts, time_from_stamp
from q2q_model.signals.topic_names import TICK_TOPICS
from q2q_model.signals.values import Array, MocapFrame, given_twice

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
IDL_MARK = "=" * 80 + "\n"
_XYZ, _XYZW = attrgetter("x", "y", "z"), attrgetter("x", "y", "z", "w")

Row = tuple[float, ...]
"""t, x y z, qx qy qz qw and, of references, velocity and acceleration; without t what a message holds."""


def read_mapped_flight(path: Path | str, topic_map: TopicMap) -> Flight:
    """Return the flight in a bag by a topic map; NaN where nothing was recorded.

    Raises:
        BagError: no bag, a mapped topic missing or of a wrong type, damage, clocks without overlap.
    """
    source, channels = mapped_channels(path, topic_map)
    signals: dict[str, Sequence[Signal]] = {
        name: _signals(source, channels[topic]) for name, topic in topic_map.signals.items()
    }
    repairs: list[str] = []
    if topic_map.vehicles or topic_map.poses:
        signals["mocap"], repairs = mapped_frames(source, channels, topic_map)
    rows = _rows_by_vehicle(source, channels, topic_map.references, topic_map, (*SETPOINTS, POSITION))
    given = {
        vehicle: References(table[:, 0], table[:, 1:4], table[:, 8:11], table[:, 11:])
        for vehicle, (table, _) in _sorted(source, rows, "references").items()
    }
    try:
        joined = flight_from_signals(flight_name(path), signals)
        flight, pauses = with_references(joined.flight, given)
    except ValueError as misfit:
        raise BagError(f"bag {path}: {misfit}") from misfit
    remarks = (*repairs, *joined.repairs, *pauses)
    warn_of_repairs(source.repairs + tuple(f"bag {path}: {remark}" for remark in remarks))
    return flight


def mapped_channels(path: Path | str, topic_map: TopicMap) -> tuple[Source, dict[str, Channel]]:
    """Return a bag and its channels by topic; raise BagError if one is missing or of another type."""
    source = open_source(path)
    channels = {channel.topic: channel for channel in source.channels}
    mapped = (topic_map.vehicles, topic_map.references, topic_map.signals)
    mapped_topics = {topic for some in mapped for topic in some.values()} | set(
        filter(None, [topic_map.poses])
    )
    missing = sorted(mapped_topics - channels.keys())
    if missing:
        raise BagError(f"bag {path} has no topic {', '.join(missing)}; it has {', '.join(sorted(channels))}")
    for name, topic in topic_map.signals.items():
        if SIGNALS.get(holds := channels[topic].type_name) is not TICK_TOPICS[name]:
            expected = f"q2q_msgs/msg/{LAYOUTS[TICK_TOPICS[name]].message}"
            raise BagError(f"topic {topic} holds {holds}; {name} under signals needs {expected}")
    return source, channels


def mapped_frames(
    source: Source, channels: dict[str, Channel], topic_map: TopicMap
) -> tuple[list[MocapFrame], list[str]]:
    """Return the mapped poses as one frame per tick, and remarks on poses left out."""
    tracks, twice = _tracks(source, channels, topic_map)
    try:
        frames, repairs = pose_frames(tracks, topic_map.tolerance_s)
    except ValueError as misfit:
        raise BagError(f"bag {source.path}: {misfit}") from misfit
    return frames, twice + repairs


def _signals(source: Source, channel: Channel) -> list[Signal]:
    reader: SignalReader[Signal] = SignalReader(SIGNALS[channel.type_name])
    try:
        return [reader.read(message.data) for message in source.read({channel.topic})]
    except BadMessageError as bad:
        raise BagError(f"bag {source.path}, topic {channel.topic}: {bad}") from bad


def _tracks(
    source: Source, channels: dict[str, Channel], topic_map: TopicMap
) -> tuple[dict[str, Poses], list[str]]:
    """Return the poses of every vehicle, and remarks on those that a message has twice."""
    rows = _rows_by_vehicle(source, channels, topic_map.vehicles, topic_map, tuple(POSES))
    named: dict[str, list[Row]] = {}
    twice: Counter[str] = Counter()
    if topic_map.poses:
        for found in _messages(source, channels[topic_map.poses], topic_map, NAMED):
            twice.update(given_twice(name for name, _ in found))
            for name, row in _once(found):
                named.setdefault(name, []).append(row)
    remarks = [f"{n} messages of {topic_map.poses} name {name} twice: left out" for name, n in twice.items()]
    _check_names(source, topic_map, list(named), remarks)
    rows |= {topic_map.rename.get(name, name): found for name, found in named.items()}
    if not rows:
        raise BagError("; ".join([f"bag {source.path} has no pose of any vehicle", *remarks]))
    return {
        vehicle: Poses(table[:, 0], table[:, 1:4], table[:, 4:8], back)
        for vehicle, (table, back) in _sorted(source, rows, "poses").items()
    }, remarks


def _once(found: Sequence[tuple[str, Row]]) -> list[tuple[str, Row]]:
    """Return the poses of vehicles that a message names once: which of two is true is not known."""
    twice = given_twice(name for name, _ in found)
    return [(name, row) for name, row in found if name not in twice]


def _check_names(source: Source, topic_map: TopicMap, named: Sequence[str], remarks: Sequence[str]) -> None:
    """Raise BagError if a vehicle has two sources of poses, or a name to replace never occurs."""
    absent = [name for name in topic_map.rename if name not in named]
    if absent:
        names = ", ".join(named) or ("none" if topic_map.poses else "none, as the topic map has no poses")
        never = f"rename has {', '.join(absent)}, and poses of it are never there; names are {names}"
        raise BagError("; ".join([f"bag {source.path}: {never}", *remarks]))
    sources = dict(topic_map.vehicles)
    for name in named:
        vehicle = topic_map.rename.get(name, name)
        if vehicle in sources:
            raise BagError(
                f"bag {source.path}: {vehicle} has poses from {sources[vehicle]} and from {name} in "
                f"{topic_map.poses}; give one of them another name under rename"
            )
        sources[vehicle] = f"{name} in {topic_map.poses}"


def _rows_by_vehicle(
    source: Source,
    channels: dict[str, Channel],
    topics: Mapping[str, str],
    topic_map: TopicMap,
    known: Sequence[str],
) -> dict[str, list[Row]]:
    return {
        vehicle: [row for found in _messages(source, channels[topic], topic_map, known) for _, row in found]
        for vehicle, topic in topics.items()
    }


def _sorted(source: Source, rows: Mapping[str, list[Row]], what: str) -> dict[str, tuple[Array, float]]:
    """Return the rows of every vehicle by time, (rows, columns), and the most that a stamp goes back [s]."""
    empty = sorted(vehicle for vehicle, found in rows.items() if not found)
    if empty:
        raise BagError(f"bag {source.path} has no {what} of {', '.join(empty)}")
    tracks = {}
    for vehicle, found in rows.items():
        table = np.array(found)
        recorded = table[:, 0]
        back = float(np.max(np.maximum.accumulate(recorded) - recorded))
        table = table[np.argsort(recorded, kind="stable")]
        if len(table) > 1 and table[0, 0] == table[-1, 0]:
            raise BagError(
                f"bag {source.path}: all {len(table)} {what} of {vehicle} have the stamp {table[0, 0]:g} s; "
                "if headers are not filled, add `stamps: receive` to the topic map"
            )
        if step := clock_set_back(recorded):
            raise BagError(f"bag {source.path}, {what} of {vehicle}: {step}")
        tracks[vehicle] = table, back
    return tracks


def _messages(
    source: Source, channel: Channel, topic_map: TopicMap, known: Sequence[str]
) -> Iterator[list[tuple[str, Row]]]:
    """Yield the poses of each message of a known type: name (empty for a topic of one vehicle) and row."""
    kind = channel.type_name.rsplit("/", 1)[-1]
    if kind not in known:
        hint = f"; {kind} is read under poses" if kind in NAMED else ""
        raise BagError(
            f"topic {channel.topic} holds {channel.type_name}, which is not read here; known are "
            f"{', '.join(known)}{hint}"
        )
    decode = _decoder(source, channel)
    for message in source.read({channel.topic}):
        try:
            value = decode(message)
            t = time_from_stamp(_stamp_ns(value) if topic_map.by_header else message.stamp_ns)
            found: list[tuple[str, Row]] = [(name, (t, *row)) for name, row in _placed(value, kind)]
        except Exception as damage:  # the decoder of rosbags asserts, indexes and unpacks
            where = f"topic {channel.topic} at {message.stamp_ns} ns"
            raise BagError(f"bag {source.path}, {where}: no {channel.type_name} ({damage})") from damage
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
            f"bag {source.path} has no definition of {channel.type_name}, and it is no common type"
        )
    read = store.deserialize_ros1 if source.ros1 else store.deserialize_cdr
    return lambda message: read(message.data, message.type_name)


def _own_types(source: Source, channel: Channel) -> Typestore:
    """Return the types that the bag defines for a channel, which may differ from those of Jazzy."""
    store, text = get_typestore(Stores.EMPTY), channel.definition
    try:
        if text.startswith(f"{IDL_MARK}IDL: "):
            for part in text.split(IDL_MARK)[1:]:
                store.register(get_types_from_idl(part.split("\n", 1)[1]))
        else:
            store.register(get_types_from_msg(text, channel.type_name))
    except Exception as damage:
        raise BagError(f"bag {source.path}: the definition of {channel.type_name} cannot be read") from damage
    return store
