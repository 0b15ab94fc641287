"""Say whether the nodes of a flight are wired: every writer has matched every reader of its topic."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass

READS = "<"
"""Marks a topic that is read, in text."""


@dataclass(frozen=True, slots=True)
class Wiring:
    """Hold what one node reads, and how many readers its writers have matched."""

    reads: tuple[str, ...]
    """Topics, once for each subscription."""
    matched: Mapping[str, int]
    """Published topic -> matched readers."""

    def as_text(self) -> str:
        """Return the wiring in words: `<topic` is read, `topic=count` is published."""
        return " ".join(
            [READS + topic for topic in self.reads] + [f"{key}={n}" for key, n in self.matched.items()]
        )


def wiring_from_text(text: str) -> Wiring:
    """Return the wiring in the words of `as_text`."""
    words = text.split()
    pairs = [word.rpartition("=") for word in words if not word.startswith(READS)]
    return Wiring(
        reads=tuple(word.removeprefix(READS) for word in words if word.startswith(READS)),
        matched={topic: int(count) for topic, _, count in pairs},
    )


def unmatched(nodes: Mapping[str, Wiring]) -> dict[str, list[str]]:
    """Return, for each node, the topics it publishes whose readers are not all matched yet."""
    readers = Counter(topic for wiring in nodes.values() for topic in wiring.reads)
    short = {
        name: [topic for topic, count in wiring.matched.items() if count < readers[topic]]
        for name, wiring in nodes.items()
    }
    return {name: topics for name, topics in short.items() if topics}
