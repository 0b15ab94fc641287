"""Connections of a flight's nodes: whether every publisher has matched every subscriber of its topic.

A latched value published before the flight (a plan) must also have arrived, and no other node may publish the
signals of these.
"""

import re
import reprlib
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

from q2q_model.signals.topic_names import TICK_TOPICS

READS, OUT, LACKS = "<", "^", "-"
"""Text marks of a topic: subscribed; latched: published, or missing."""
WORD = re.compile(r"[<^-]/\S*|/\S*=[0-9]{1,9}")
"""Word of the text of connections: a topic with its mark, or one with its number of matched subscribers."""


@dataclass(frozen=True, slots=True)
class Connections:
    """Inputs of one node and the number of subscribers its publishers have matched."""

    reads: tuple[str, ...]
    """Topics, once per subscription."""
    matched: Mapping[str, int]
    """Published topic -> matched subscribers."""
    out: tuple[str, ...] = ()
    """Published latched topics that have a value."""
    lacks: tuple[str, ...] = ()
    """Subscribed latched topics without a value yet."""

    def as_text(self) -> str:
        """Return the connections as text: `<topic` is subscribed to, `topic=count` is published."""
        marked = ((READS, self.reads), (OUT, self.out), (LACKS, self.lacks))
        return " ".join(
            [mark + topic for mark, topics in marked for topic in topics]
            + [f"{key}={n}" for key, n in self.matched.items()]
        )


def connections_from_text(text: str, node: str) -> Connections:
    """Return the connections in the text of `as_text`; raise ValueError, naming the node, for others."""
    words = text.split()
    if not all(map(WORD.fullmatch, words)):
        raise ValueError(
            f"{node} answers {reprlib.repr(text)} to ~/ready, not topics with their readers: "
            "it may not be a q2q node of this version; end it, or give this flight another ROS_DOMAIN_ID"
        )
    marks = (READS, OUT, LACKS)
    reads, out, lacks = (
        tuple(word.removeprefix(mark) for word in words if word.startswith(mark)) for mark in marks
    )
    pairs = [word.rpartition("=") for word in words if not word.startswith(marks)]
    return Connections(reads, {topic: int(count) for topic, _, count in pairs}, out, lacks)


def unmatched_topics(nodes: Mapping[str, Connections]) -> dict[str, list[str]]:
    """Return, for each node, the published topics that lack a matched subscriber."""
    readers = Counter(topic for one in nodes.values() for topic in one.reads)
    short = {
        name: [topic for topic, count in one.matched.items() if count < readers[topic]]
        for name, one in nodes.items()
    }
    return {name: topics for name, topics in short.items() if topics}


def undelivered_topics(nodes: Mapping[str, Connections]) -> dict[str, list[str]]:
    """Return, for each node, the latched topics whose published value it has not received yet."""
    out = {topic for one in nodes.values() for topic in one.out}
    missing = {name: [topic for topic in one.lacks if topic in out] for name, one in nodes.items()}
    return {name: topics for name, topics in missing.items() if topics}


def conflicting_topics(
    nodes: Mapping[str, Connections], publishers_of: Callable[[str], Sequence[str]]
) -> str:
    """Return which signals nodes other than these publish, with the names of all who do; empty if none does.

    Args:
        nodes: nodes of a flight.
        publishers_of: returns the names of all nodes that publish a topic, once for each publisher.
    """
    ours = Counter(topic for one in nodes.values() for topic in one.matched)
    found = {
        topic: writers
        for topic, count in ours.items()
        if topic.rpartition("/")[2] in TICK_TOPICS and len(writers := sorted(publishers_of(topic))) > count
    }
    return "; ".join(
        f"{topic} is written by {len(writers)} nodes ({', '.join(writers)})"
        for topic, writers in found.items()
    )


def conflicting_nodes(node: str, publishers: Sequence[Sequence[str]]) -> str:
    """Return the names of other nodes that publish the same topics; empty if there are none.

    Args:
        node: name of this node, which publishes each topic once.
        publishers: the publishing nodes of each topic.
    """
    found = {name for names in publishers for name in names}
    same_name = {node} if max(map(len, publishers), default=0) > 1 and found <= {node} else set()
    return ", ".join(sorted((found - {node}) | same_name))


def missing_connections(names: Iterable[str], nodes: Mapping[str, Connections]) -> list[str]:
    """Return descriptions of what the named nodes still wait for; `nodes` are those that have answered."""
    silent = [f"{name} has not answered" for name in names if name not in nodes]
    return silent or [
        *(
            f"{name} waits for readers of {', '.join(topics)}"
            for name, topics in unmatched_topics(nodes).items()
        ),
        *(f"{name} waits for {', '.join(topics)}" for name, topics in undelivered_topics(nodes).items()),
    ]
