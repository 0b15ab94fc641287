"""Frames that the headers of mapped topics name: positions in different frames cannot be compared."""

import struct
from collections.abc import Mapping

from q2q_model.bag.foreign.topic_map import TopicMap
from q2q_model.bag.storage.definitions import naming_message
from q2q_model.bag.storage.errors import BagError
from q2q_model.bag.storage.source import Channel, Source
from q2q_model.counted import first_of

LENGTH_AT = 12
"""Offset of the length of frame_id: after encapsulation and stamp in CDR, number and stamp in ROS 1."""
MOST = 5
"""Most topics in an error, and frames of each."""


def check_frames(source: Source, channels: Mapping[str, Channel], topic_map: TopicMap) -> None:
    """Raise BagError if poses and references are of several frames, unless `frames` of the map has them all.

    An empty frame_id says nothing, and a leading slash (ROS 1, Crazyswarm2) makes no other frame.
    """
    topics = (*topic_map.vehicles.values(), topic_map.poses, *topic_map.references.values())
    of_topic = {topic: _frames(source, channels[topic]) for topic in dict.fromkeys(filter(None, topics))}
    frames = list(dict.fromkeys(frame for found in of_topic.values() for frame in found))
    if len(frames) < 2 or set(frames) <= {_without_slash(frame) for frame in topic_map.frames}:
        return
    where = [
        f"{topic} in {' and '.join(first_of(found, MOST))}" for topic, found in of_topic.items() if found
    ]
    raise BagError(
        f"bag {source.path}: poses and references are in {len(frames)} frames: "
        f"{', '.join(first_of(where, MOST))}; map topics of one frame, or, if these are names of one, list "
        "them under `frames` in the topic map"
    )


def _frames(source: Source, channel: Channel) -> list[str]:
    """Return the frames that the headers of a topic name, in the order of the recording."""
    found: dict[str, None] = {}
    for message in source.read({channel.topic}):
        with naming_message(source.path, message, channel.type_name):
            order = "<" if source.ros1 or message.data[1] & 1 else ">"
            begin, (size,) = LENGTH_AT + 4, struct.unpack_from(f"{order}I", message.data, LENGTH_AT)
            text = message.data[begin : begin + size].decode()
        found[_without_slash(text.rstrip("\0"))] = None
    return [frame for frame in found if frame]


def _without_slash(frame: str) -> str:
    return frame.removeprefix("/")
