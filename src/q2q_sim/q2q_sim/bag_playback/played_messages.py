"""Messages of a bag that are played: of the chosen topics, from a start on, up to the end or the damage.

A subscriber of a latched topic needs the last message even if it is from before the start.
"""

from collections.abc import Collection, Iterable, Iterator, Mapping

from q2q_model.bag import BagError, BagReader, MappedBag, RawMessage
from q2q_sim.flight_bag.topics import is_latched


class PlayedMessages:
    """Position in a bag: `next` is the message to play, None at the end."""

    def __init__(self, bag: BagReader | MappedBag, topics: Mapping[str, str], start: float) -> None:
        """Take the topics to play with their types, and the seconds of the whole bag to skip [s]."""
        self.next: RawMessage | None = None
        self.damage: BagError | None = None
        """Damage at which the bag ends, once it is reached."""
        self.begin_ns = _bag_begin_ns(bag) + round(start * 1e9)
        """Bag time of the start [ns]."""
        self.latched = {one for one, kind in topics.items() if one in bag.latched or is_latched(one, kind)}
        """Topics that are played latched."""
        self._bag, self._topics = bag, set(topics)
        self._messages: Iterator[RawMessage] = iter(())

    def rewind(self) -> Iterable[RawMessage]:
        """Go to the start; return the last message before it of each latched topic."""
        self._messages = self._bag.raw(self._topics)
        self.advance()
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


def check_start(bag: BagReader | MappedBag, topics: Collection[str], start: float) -> None:
    """Raise ValueError if no message of these topics is `start` [s] after the first of the bag, or later."""
    begin_ns, last_ns = _bag_begin_ns(bag), None
    for message in bag.raw(topics):
        last_ns = message.stamp_ns
        if last_ns >= begin_ns + round(start * 1e9):
            return
    names = ", ".join(sorted(topics))
    if last_ns is None:
        raise ValueError(f"the bag has no message to play: none on {names}")
    last = f"the last message on {names} is {(last_ns - begin_ns) * 1e-9:.1f} s after the bag's first"
    raise ValueError(f"parameter start = {start:g} s: {last}")


def _bag_begin_ns(bag: BagReader | MappedBag) -> int:
    """Return the bag time of the first message of any topic [ns].

    Raises:
        ValueError: the bag is empty.
    """
    first = next(bag.raw(bag.topics), None)
    if first is None:
        raise ValueError("the bag has no message to play")
    return first.stamp_ns
