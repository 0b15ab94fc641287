"""Messages of a bag tick by tick.

A message belongs to the tick whose header stamp it carries; others belong to the last tick before them. An
answer to a tick may need several of its messages (a command needs state and reference), and a bag whose times
are those of receipt may hold some of them before the tick, or after the next one.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

from q2q_model.bag import RawMessage
from q2q_model.signals.cdr.cdr_format import header_stamp_ns
from q2q_sim.bag_playback.played_messages import PlayedMessages

REACH_NS = 200_000_000
"""Bag time after a tick up to which messages of its stamp are looked for [ns]: twenty ticks at 100 Hz."""


@dataclass(frozen=True, slots=True)
class BagTick:
    """Messages of one tick, in the order of the bag; bag times do not fall from tick to tick."""

    tick: RawMessage | None
    """Message that is the tick; None if the bag has no further one."""
    messages: tuple[RawMessage, ...]
    """Messages to play; empty at the end of the bag."""
    stamped: tuple[RawMessage, ...] = ()
    """Those with the header stamp of the tick."""


@dataclass(frozen=True, slots=True)
class _Read:
    """Message that was read and not yet played."""

    message: RawMessage
    header_ns: int | None
    """Header stamp [ns]; None if the message is too short to have one, meaningless if its type has none."""


class TickMessages:
    """Messages to play, taken tick by tick."""

    def __init__(self, messages: PlayedMessages, topics: set[str]) -> None:
        """Take the position in the bag, and the topics whose messages are ticks."""
        self._messages, self._topics = messages, topics
        self._read: list[_Read] = []
        self._ticks: list[_Read] = []
        """Those of `_read` that are ticks."""
        self._bag_ns = 0

    def rewind(self) -> None:
        """Forget what was read."""
        self._read, self._ticks, self._bag_ns = [], [], 0

    @property
    def is_over(self) -> bool:
        """Return whether every message was taken."""
        return self._messages.next is None and not self._read

    def take(self) -> BagTick:
        """Return the messages of the next tick, with those that lie before the first one."""
        self._read_on()
        first, following = next(iter(self._ticks), None), self._following()
        stamps = {one.header_ns for one in self._ticks}
        before = True
        taken: list[_Read] = []
        left: list[_Read] = []
        for one in self._read:
            before = before and one is not following
            is_taken = one.header_ns == first.header_ns if first and one.header_ns in stamps else before
            (taken if is_taken else left).append(one)
        self._read = left
        messages = tuple(self._timed(taken, following))
        if first is None:
            return BagTick(None, messages)
        self._ticks = [one for one in self._ticks if one.header_ns != first.header_ns]
        stamped = tuple(one.message for one in taken if one.header_ns == first.header_ns)
        return BagTick(first.message, messages, stamped)

    def _read_on(self) -> None:
        """Read the next tick, the one after it, and what else can be of the next tick's stamp."""
        while (message := self._messages.next) is not None:
            if self._following() and message.stamp_ns > self._ticks[0].message.stamp_ns + REACH_NS:
                return
            one = _Read(message, _header_ns(message))
            self._read.append(one)
            if message.topic in self._topics:
                self._ticks.append(one)
            self._messages.advance()

    def _following(self) -> _Read | None:
        """Return the tick after the next one; a frame that was sent twice is one tick."""
        return next((one for one in self._ticks if one.header_ns != self._ticks[0].header_ns), None)

    def _timed(self, taken: list[_Read], following: _Read | None) -> Iterator[RawMessage]:
        """Yield messages at bag times that neither fall nor exceed that of the following tick."""
        for one in taken:
            stamp_ns = max(one.message.stamp_ns, self._bag_ns)
            self._bag_ns = min(stamp_ns, following.message.stamp_ns) if following else stamp_ns
            yield replace(one.message, stamp_ns=self._bag_ns)


def _header_ns(message: RawMessage) -> int | None:
    try:
        return header_stamp_ns(message.data)
    except ValueError:
        return None
