"""Messages of a bag of other software under q2q topics, by a topic map and in order of their stamps.

Messages of topics under `signals` are unchanged; poses become frames on `mocap`, as in `read_mapped_flight`.
References are omitted, because they are positions without velocity, which no node accepts.
"""

from collections.abc import Collection, Iterator
from dataclasses import replace
from pathlib import Path

from q2q_model.bag.foreign.clock_offset import clock_remarks
from q2q_model.bag.foreign.header_frames import check_frames
from q2q_model.bag.foreign.mapped_flight import mapped_channels
from q2q_model.bag.foreign.mapped_poses import mapped_frames
from q2q_model.bag.foreign.topic_map import TopicMap
from q2q_model.bag.storage.source import RawMessage
from q2q_model.signals.cdr.cdr_format import header_stamp_ns
from q2q_model.signals.cdr.cdr_writer import encode
from q2q_model.signals.layout import LAYOUTS
from q2q_model.signals.stamps import stamp_from_time

MOCAP = "mocap"


class MappedBag:
    """Messages of a bag under the topics of a topic map."""

    def __init__(self, path: Path | str, topic_map: TopicMap) -> None:
        """Read the bag at `path`; raise BagError as `read_mapped_flight` does."""
        source, channels = mapped_channels(path, topic_map)
        messages: list[RawMessage] = []
        for topic, of_bag in topic_map.signals.items():
            for one in source.read({of_bag}):
                stamp_ns = header_stamp_ns(one.data) if topic_map.by_header else one.stamp_ns
                messages.append(RawMessage(topic, stamp_ns, one.data, one.type_name))
        self.latched: frozenset[str] = frozenset()
        """Topics that were recorded as latched: none, as they are signals of ticks."""
        self.repairs = source.repairs
        """Repairs needed to read the bag, one sentence each."""
        if topic_map.vehicles or topic_map.poses:
            frames, repairs = mapped_frames(source, channels, topic_map)
            of_poses = replace(topic_map, references={})
            check_frames(source, channels, of_poses)
            repairs += clock_remarks(source, channels, of_poses)
            self.repairs += tuple(f"bag {path}: {repair}" for repair in repairs)
            for frame in frames:
                kind = f"q2q_msgs/msg/{LAYOUTS[type(frame)].message}"
                stamp_ns = stamp_from_time(frame.t)
                messages.append(RawMessage(MOCAP, stamp_ns, encode(frame, stamp_ns), kind))
        self._messages = sorted(messages, key=lambda one: one.stamp_ns)

    @property
    def topics(self) -> dict[str, str]:
        """Return every mapped topic and its message type."""
        return {one.topic: one.type_name for one in self._messages}

    def raw(self, topics: Collection[str]) -> Iterator[RawMessage]:
        """Yield the messages of topics in the order of their stamps."""
        return (one for one in self._messages if one.topic in topics)
