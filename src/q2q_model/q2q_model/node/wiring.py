"""Say whether the nodes of a flight are wired: every writer has matched every reader of its topic.

A latched value that is out before the flight (a plan) must have arrived, too.
"""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass

READS, WATCHES, PROMISES, OUT, LACKS = "<", "?", "!", "^", "-"
"""Mark a topic in text: read, watched, published with a promise; latched: out, or not here yet."""
PROMISE_S = 0.02
"""What nodes of a live flight promise [s]: two ticks, within the hold_s of q2q_control.failsafe.ladder."""


@dataclass(frozen=True, slots=True)
class Wiring:
    """Inputs of one node and the number of readers its writers have matched."""

    reads: tuple[str, ...]
    """Topics, once for each subscription."""
    matched: Mapping[str, int]
    """Published topic -> matched readers."""
    watches: tuple[str, ...] = ()
    """Topics watched: a writer that promises nothing never matches these (q2q_model.ros.topics.deadlines)."""
    promises: tuple[str, ...] = ()
    """Topics published with a promise."""
    out: tuple[str, ...] = ()
    """Latched topics published of which a value is out."""
    lacks: tuple[str, ...] = ()
    """Latched topics read of which no value has come yet."""

    def as_text(self) -> str:
        """Return the wiring in words: `<topic` is read, `topic=count` is published."""
        marked = (
            (READS, self.reads),
            (WATCHES, self.watches),
            (PROMISES, self.promises),
            (OUT, self.out),
            (LACKS, self.lacks),
        )
        return " ".join(
            [mark + topic for mark, topics in marked for topic in topics]
            + [f"{key}={n}" for key, n in self.matched.items()]
        )


def wiring_from_text(text: str) -> Wiring:
    """Return the wiring in the words of `as_text`."""
    words = text.split()
    marks = (READS, WATCHES, PROMISES, OUT, LACKS)
    reads, watches, promises, out, lacks = (
        tuple(word.removeprefix(mark) for word in words if word.startswith(mark)) for mark in marks
    )
    pairs = [word.rpartition("=") for word in words if not word.startswith(marks)]
    return Wiring(reads, {topic: int(count) for topic, _, count in pairs}, watches, promises, out, lacks)


def unmatched(nodes: Mapping[str, Wiring]) -> dict[str, list[str]]:
    """Return, for each node, the topics it publishes whose readers are not all matched yet."""
    readers = Counter(topic for wiring in nodes.values() for topic in wiring.reads)
    watchers = Counter(topic for wiring in nodes.values() for topic in wiring.watches)
    short = {
        name: [
            topic
            for topic, count in wiring.matched.items()
            if count < readers[topic] + (watchers[topic] if topic in wiring.promises else 0)
        ]
        for name, wiring in nodes.items()
    }
    return {name: topics for name, topics in short.items() if topics}


def unserved(nodes: Mapping[str, Wiring]) -> dict[str, list[str]]:
    """Return, for each node, the latched topics of which a value is out and has not come to it yet."""
    out = {topic for wiring in nodes.values() for topic in wiring.out}
    lacking = {name: [topic for topic in wiring.lacks if topic in out] for name, wiring in nodes.items()}
    return {name: topics for name, topics in lacking.items() if topics}
