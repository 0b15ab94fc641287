"""Messages of a bag that are played: of the chosen topics, from a start on, up to the end or the damage.

A subscriber of a latched topic needs the last message even if it is from before the start.
"""

from collections.abc import Collection, Iterable, Iterator, Mapping

from q2q_model.bag import BagError, BagReader, MappedBag, RawMessage
from q2q_sim.bag_topics.topics import is_latched


class PlayedMessages:
    """Position in a bag: `next` is the message to play, None at the end."""

    def __init__(self, bag: BagReader | MappedBag, topics: Mapping[str, str], start: float) -> None:
        """Take the topics to play with their types, and the seconds of the bag to skip [s]."""
        self.next: RawMessage | None = None
        self.damage: BagError | None = None
        """Damage at which the bag ends, once it is reached."""
        self.begin_ns = 0
        """Bag time of the start, once it is reached [ns]."""
        self.latched = {one for one, kind in topics.items() if one in bag.latched or is_latched(one, kind)}
        """Topics that are played latched."""
        self._bag, self._topics, self._start = bag, set(topics), start
        self._messages: Iterator[RawMessage] = iter(())

    def rewind(self) -> Iterable[RawMessage]:
        """Go to the start; return the last message before it of each latched topic."""
        self._messages = self._bag.raw(self._topics)
        self.advance()
        self.begin_ns = self.next.stamp_ns + round(self._start * 1e9) if self.next else 0
        last: dict[str, RawMessage] = {}
        while self.next is not None and self.next.stamp_ns < self.begin_ns:
            if self.next.topic in self.latched:
                last[self.next.topic] = self.next
            self.advance()
        return last.values()

    def advance(self) -> None:
        """Go to the next message; the bag ends where it is damaged."""
        try:
            self.next = next(self._messages, None)
        except BagError as damage:
            self.next, self.damage = None, damage


def played_topics(recorded: Mapping[str, str], chosen: Collection[str]) -> dict[str, str]:
    """Return the topics to play with their types: those chosen of a bag, all if none are.

    Raises:
        ValueError: the bag lacks a chosen topic.
    """
    wanted = {topic.strip("/") for topic in chosen}
    missing = wanted - {topic.strip("/") for topic in recorded}
    if missing:
        known = ", ".join(sorted(recorded))
        raise ValueError(f"parameter topics: the bag has no {', '.join(sorted(missing))}; it has {known}")
    return {topic: kind for topic, kind in recorded.items() if not wanted or topic.strip("/") in wanted}


def check_start(stamps: Iterable[int], start: float) -> None:
    """Raise ValueError if there is no message, or none from `start` [s] on; `stamps` rise [ns]."""
    left = iter(stamps)
    first = next(left, None)
    if first is None:
        raise ValueError("the bag has no message to play")
    since, begin = 0, round(start * 1e9)
    while since < begin:
        later = next(left, None)
        if later is None:
            raise ValueError(f"parameter start = {start:g} s: the bag lasts {since / 1e9:.1f} s")
        since = later - first
