"""Offset between the clocks that stamp the topics of a bag, from the times at which it received them.

Two messages with the same stamp of one clock are received at the same time, but for the difference of their
latencies. If the stamps are of two clocks, the times of receipt differ by the offset of the clocks, as well.
Latencies vary, and messages that are held up come late in bursts: an offset is what nine tenths of the
messages of a half of the flight have in common, which shows a clock that drifts in the second half.

A long latency and stamps that are set ahead look like an offset: it is a remark, and refuses nothing. Bags
that were written anew, with times of receipt that are all equal or those of the headers, show none. In a bag
that was played back slowly and recorded again, latencies count by the stamps' time.
"""

import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from q2q_model.bag.foreign.topic_map import TopicMap
from q2q_model.bag.storage.definitions import naming_message
from q2q_model.bag.storage.source import Channel, RawMessage, Source
from q2q_model.signals.cdr.cdr_format import header_stamp_ns
from q2q_model.signals.stamps import stamp_from_parts, time_from_stamp
from q2q_model.signals.values import Array, Mask

OFFSET_S = 0.1
"""Offset that is reported [s]: latencies of motion capture, networks and recorders are tens of ms."""
PARTS = 2
"""Parts of a flight, each of which may show an offset."""
FEWEST_MESSAGES = 3
"""Messages of a part from which an offset is known: the first may be an old one that was latched."""
OUTLYING = 0.1
"""Share of the messages that may be received earlier, or later, than an offset says."""


@dataclass(frozen=True, slots=True)
class MessageTimes:
    """Times of the messages of a topic in the order of the recording."""

    stamps: Array
    """(messages,), of their headers [s]."""
    received: Array
    """(messages,), of the recorder [s]."""


def clock_remarks(source: Source, channels: Mapping[str, Channel], topic_map: TopicMap) -> Iterator[str]:
    """Yield a remark for each topic of mapped poses and references whose clock is not that of the first.

    None is yielded where times of receipt are read, or poses are those of a signal.
    """
    poses = [*topic_map.vehicles.values(), *filter(None, [topic_map.poses])]
    first, *others = dict.fromkeys((*poses, *topic_map.references.values())) if poses else [""]
    if not (others and topic_map.by_header):
        return
    times = _times(source, channels[first])
    for topic in others:
        ahead_s = clock_offset(times, _times(source, channels[topic]))
        if abs(ahead_s) > OFFSET_S:
            side = "ahead of" if ahead_s > 0.0 else "behind"
            yield (
                f"stamps of {topic} are {1e3 * abs(ahead_s):.0f} ms {side} those of {first} that were "
                "received at the same time; if they come from two clocks, add `stamps: receive` to the "
                "topic map"
            )


def clock_offset(one: MessageTimes, other: MessageTimes) -> float:
    """Return how far the clock of `other` is ahead of that of `one` [s]; 0 if the times do not tell.

    It is that of the part in which it is largest. A stamp that is sent again counts once.
    """
    one, other = _first_of_each_stamp(one), _first_of_each_stamp(other)
    if not (len(one.stamps) and len(other.stamps)):
        return 0.0
    within = _within(other.stamps, one.stamps) & _within(other.received, one.received)
    expected = np.interp(other.stamps[within], one.stamps, one.received)
    slowness = np.ptp(one.received) / max(np.ptp(one.stamps), np.finfo(float).tiny)
    ahead = (expected - other.received[within]) / max(float(slowness), 1.0)
    if len(ahead) < FEWEST_MESSAGES:
        return 0.0
    parts = np.array_split(ahead, min(PARTS, len(ahead) // FEWEST_MESSAGES))
    return max((_in_common(part) for part in parts), key=abs)


def _times(source: Source, channel: Channel) -> MessageTimes:
    stamps, received = [], []
    for message in source.read({channel.topic}):
        with naming_message(source.path, message, channel.type_name):
            stamp_ns = _stamp_of_ros1(message) if source.ros1 else header_stamp_ns(message.data)
        stamps.append(time_from_stamp(stamp_ns))
        received.append(time_from_stamp(message.stamp_ns))
    return MessageTimes(np.array(stamps), np.array(received))


def _stamp_of_ros1(message: RawMessage) -> int:
    """Return the stamp of a header of ROS 1 [ns], which a sequence number precedes."""
    return stamp_from_parts(*struct.unpack_from("<II", message.data, 4))


def _first_of_each_stamp(times: MessageTimes) -> MessageTimes:
    stamps, first = np.unique(times.stamps, return_index=True)
    return MessageTimes(stamps, times.received[first])


def _within(t: Array, span: Array) -> Mask:
    return np.asarray((t >= span.min()) & (t <= span.max()))


def _in_common(ahead: Array) -> float:
    """Return the offset that all but OUTLYING of some differences exceed [s]; 0 if their signs differ."""
    low, high = np.quantile(ahead, (OUTLYING, 1.0 - OUTLYING))
    return float(max(low, 0.0) + min(high, 0.0))
