"""Offset between the clocks that stamp the topics of a bag, from the times at which it received them.

Two messages with the same stamp of one clock are received at the same time, but for the difference of their
latencies. If the stamps are of two clocks, the times of receipt differ by the offset of the clocks, as well.
Latencies vary, and messages that are held up come late in bursts: an offset is what nine tenths of the
messages of a quarter of the flight have in common, which shows a clock that drifts in the last quarter.

Bags that were written anew, with times of receipt that are all equal or those of the headers, show no offset.
So does a bag that is played back and recorded again, at any rate: both topics are received as late.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from q2q_model.bag.foreign.pose_messages import message_times
from q2q_model.bag.foreign.topic_map import TopicMap
from q2q_model.bag.storage.errors import BagError
from q2q_model.bag.storage.source import Channel, Source
from q2q_model.signals.values import Array, Mask

OFFSET_S = 0.1
"""Offset from which two clocks differ [s]: latencies of cameras, networks and recorders are tens of ms."""
QUARTERS = 4
"""Parts of a flight, each of which may show an offset."""
LEAST = 3
"""Messages from which an offset is known: the first may be an old one that was latched."""
SHARE = 0.1
"""Share of the messages that may be received earlier, or later, than an offset says."""


@dataclass(frozen=True, slots=True)
class MessageTimes:
    """Times of the messages of a topic in the order of the recording."""

    stamps: Array
    """(messages,), of their headers [s]."""
    received: Array
    """(messages,), of the recorder [s]."""


def check_one_clock(source: Source, channels: Mapping[str, Channel], topic_map: TopicMap) -> None:
    """Raise BagError if headers of mapped poses and references are read, and are of two clocks."""
    poses = [*topic_map.vehicles.values(), *filter(None, [topic_map.poses])]
    if not (poses and topic_map.by_header):
        return
    first, *others = dict.fromkeys((*poses, *topic_map.references.values()))
    times = MessageTimes(*message_times(source, channels[first]).T)
    for topic in others:
        ahead_s = clock_offset(times, MessageTimes(*message_times(source, channels[topic]).T))
        if abs(ahead_s) > OFFSET_S:
            raise BagError(
                f"bag {source.path}: stamps of {topic} are {abs(ahead_s):.2f} s or more "
                f"{'ahead of' if ahead_s > 0.0 else 'behind'} those of {first} that were received at the "
                "same time: the clocks differ; add `stamps: receive` to the topic map, and synchronise the "
                "clocks before the next flight"
            )


def clock_offset(one: MessageTimes, other: MessageTimes) -> float:
    """Return how far the clock of `other` is ahead of that of `one` [s]; 0 if the times do not tell.

    It is that of the quarter in which it is largest. A stamp that is sent again counts once.
    """
    one, other = _first_of_each_stamp(one), _first_of_each_stamp(other)
    within = _within(other.stamps, one.stamps) & _within(other.received, one.received)
    expected = np.interp(other.stamps[within], one.stamps, one.received)
    ahead = expected - other.received[within]
    if len(ahead) < LEAST:
        return 0.0
    parts = np.array_split(ahead, min(QUARTERS, len(ahead) // LEAST))
    return max((_in_common(part) for part in parts), key=abs)


def _first_of_each_stamp(times: MessageTimes) -> MessageTimes:
    stamps, first = np.unique(times.stamps, return_index=True)
    return MessageTimes(stamps, times.received[first])


def _within(t: Array, span: Array) -> Mask:
    return np.asarray((t >= span.min()) & (t <= span.max()))


def _in_common(ahead: Array) -> float:
    """Return the offset that all but SHARE of some differences exceed [s]; 0 if their signs differ."""
    low, high = np.quantile(ahead, (SHARE, 1.0 - SHARE))
    return float(max(low, 0.0) + min(high, 0.0))
