"""Bag that a recorder fills: what it stores, refuses and lacks, and what is said of it.

A disk that takes no more ends the recording, but not the recorder, so that a flight is flown to its end.
"""

import sys
from collections.abc import Callable, Collection
from contextlib import suppress

from q2q_model.bag import BagError, BagWriter, OfferedQos
from q2q_model.bag.storage.definitions import definition_of
from q2q_model.counted import counted
from q2q_model.diagnostics.health import Health
from q2q_model.signals.cdr.cdr_format import header_stamp_ns
from q2q_model.signals.cdr.cdr_writer import encode
from q2q_model.signals.layout import Signal
from q2q_sim.flight_bag.recorded_topics import silent_topics_note


class RecordedBag:
    """Bag with the messages stored in it and the count of those that it lacks."""

    def __init__(
        self,
        writer: BagWriter,
        offered: Callable[[str], OfferedQos],
        clock: Callable[[], int] | None = None,
    ) -> None:
        """Take an empty bag.

        Args:
            writer: the bag.
            offered: returns what the publishers of a topic offer now.
            clock: returns the time of receipt [ns]; None takes the stamp in a message's header for its time.
        """
        self.health = Health()
        """Messages stored (ticks) and lost (missed)."""
        self.is_full = False
        """Whether the disk has taken no more."""
        self.received: set[str] = set()
        """Topics with a message."""
        self.other_types: dict[str, str] = {}
        """Topics without one that were last seen published with another type, with a note of it."""
        self._writer, self._offered, self._clock = writer, offered, clock
        self._foreign: dict[str, str] = {}
        """Topics that others may write and their types, until the first message shows what is offered."""
        self._lost: dict[str, int] = {}

    def add_topic(self, topic: str, kind: str, *, latched: bool) -> None:
        """Add a topic whose quality of service is known."""
        self._writer.add_topic(topic, kind, OfferedQos(transient_local=latched))

    def add_foreign(self, topic: str, kind: str) -> None:
        """Add a topic that others may write, by what its publishers offer at its first message."""
        definition_of(kind)  # takes longest for the first topic: not while messages come
        self._foreign[topic] = kind

    def take(self, topic: str, data: bytes) -> None:
        """Store a serialised message."""
        try:
            stamp_ns = self._clock() if self._clock else header_stamp_ns(data)
        except ValueError as refusal:
            self.health.refuse(f"{topic}: {refusal}; not recorded")
            return
        self._store(topic, stamp_ns, data)

    def take_signal(self, topic: str, stamp_ns: int, signal: Signal) -> None:
        """Store a signal that was stamped at `stamp_ns`."""
        self._store(topic, self._clock() if self._clock else stamp_ns, encode(signal, stamp_ns))

    def count_lost(self, topic: str, total: int) -> None:
        """Count the messages of a topic, `total` since the start, that came and were not read in time."""
        self.health.missed += total - self._lost.get(topic, 0)
        self._lost[topic] = total

    def close(self, asked: Collection[str]) -> None:
        """Close the bag; say which topics lost messages, and which of those `asked` for never came.

        Raises:
            BagError: the disk took no more, before or now.
        """
        try:
            for topic, kind in self._foreign.items() if not self.is_full else ():
                self._writer.add_topic(topic, kind)
            self._writer.close()
        except BagError as refusal:
            self._give_up(refusal)
        for note in self.other_types.values():
            _say(note)
        if silence := silent_topics_note(asked, self.received | self.other_types.keys()):
            _say(silence)
        for topic, count in self._lost.items():
            _say(f"lost {counted(count, 'message')} of {topic}: this machine is too busy")
        if self.is_full:
            raise BagError(f"bag {self._writer.path} lacks the messages after its disk was full")

    def _store(self, topic: str, stamp_ns: int, data: bytes) -> None:
        self.received.add(topic)
        self.other_types.pop(topic, None)
        if self.is_full:
            self.health.missed += 1
            return
        if stamp_ns < 0:
            self.health.refuse(f"{topic}: stamp of {1e-9 * stamp_ns:g} s; must be at least 0 s; not recorded")
            return
        if topic in self._foreign:
            self._writer.add_topic(topic, self._foreign.pop(topic), self._offered(topic))
        try:
            self._writer.write_raw(topic, stamp_ns, data)
        except BagError as refusal:
            self._give_up(refusal)
        else:
            self.health.ticks += 1

    def _give_up(self, refusal: BagError) -> None:
        """Record nothing further."""
        self.is_full = True
        self.health.refuse(str(refusal))
        with suppress(OSError):  # a log on the same disk
            _say(f"{refusal}; nothing more is recorded")


def _say(words: str) -> None:
    print(f"bag_record: {words}", file=sys.stderr, flush=True)
