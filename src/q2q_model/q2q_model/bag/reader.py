"""Reader of a bag: topics, messages as bytes, and signals."""

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from operator import attrgetter
from pathlib import Path

from q2q_model.bag.storage.errors import BagError
from q2q_model.bag.storage.open_source import open_source
from q2q_model.bag.storage.own_definition import check_fields
from q2q_model.bag.storage.source import Channel, RawMessage
from q2q_model.signals.cdr.cdr_format import BadMessageError
from q2q_model.signals.cdr.cdr_reader import SignalReader
from q2q_model.signals.cdr.cdr_rows import rows_of_messages
from q2q_model.signals.layout import SIGNALS, Signal
from q2q_model.signals.rows import SignalRows

__all__ = ["BagReader", "RawMessage", "TimedSignal"]


@dataclass(frozen=True, slots=True)
class TimedSignal:
    """One decoded message of a bag."""

    topic: str
    stamp_ns: int
    """Bag time [ns]; the capture time is `signal.t`."""
    signal: Signal


class BagReader:
    """Reader of a bag; every method reads from its beginning."""

    def __init__(self, path: Path | str) -> None:
        """Open the bag at `path`; raise BagError if it cannot be read."""
        self._source = open_source(path)

    @property
    def path(self) -> Path:
        """Return the bag's path."""
        return self._source.path

    @property
    def channels(self) -> tuple[Channel, ...]:
        """Return every channel."""
        return self._source.channels

    @property
    def topics(self) -> dict[str, str]:
        """Return every topic and its message type."""
        return {channel.topic: channel.type_name for channel in self._source.channels}

    @property
    def latched(self) -> frozenset[str]:
        """Return the topics that were recorded as latched."""
        return frozenset(channel.topic for channel in self._source.channels if channel.latched)

    @property
    def repairs(self) -> tuple[str, ...]:
        """Return the repairs needed to read the bag, one sentence each."""
        return self._source.repairs

    @property
    def is_cut(self) -> bool:
        """Return whether messages may be missing: its writer was killed, or the file was damaged."""
        return self._source.is_cut

    def raw(self, topics: Collection[str] | None = None) -> Iterator[RawMessage]:
        """Yield messages as bytes in the order of bag time; None means all topics.

        Raises BagError for a topic that the bag lacks, for a type of q2q_msgs that the bag defines with other
        fields, and for damage when it is reached.
        """
        selected = self.topics.keys() if topics is None else topics
        missing = sorted(set(selected) - self.topics.keys())
        if missing:
            has = ", ".join(sorted(self.topics)) or "no topics"
            raise BagError(f"bag {self.path} has no topic {', '.join(missing)}; it has {has}")
        for channel in self.channels:
            if channel.topic in selected:
                check_fields(self.path, channel)
        return self._source.read(selected)

    def signals(self, topics: Collection[str] | None = None) -> Iterator[TimedSignal]:
        """Yield the decoded messages of q2q_msgs signal types; other types are skipped.

        Raises BagError for a message that does not fit its type.
        """
        selected = self.topics.keys() if topics is None else topics
        foreign = {channel.topic for channel in self.channels if channel.type_name not in SIGNALS}
        readers: dict[str, SignalReader[Signal]] = {
            channel.topic: SignalReader(SIGNALS[channel.type_name])
            for channel in self.channels
            if channel.topic not in foreign
        }
        for message in self.raw(set(selected) - foreign):
            try:
                signal: Signal = readers[message.topic].read(message.data)
            except BadMessageError as bad:
                raise BagError(
                    f"bag {self.path}, topic {message.topic} at {message.stamp_ns} ns: {bad}"
                ) from bad
            yield TimedSignal(message.topic, message.stamp_ns, signal)

    def rows(self, topics: Collection[str]) -> dict[str, list[SignalRows]]:
        """Return the messages of signal topics, by topic, as arrays over time, in the order of recording.

        In lockstep bag times are those of headers, which a clock that jumped back has twice.

        Raises BagError for a missing topic, damage, or a message that does not fit its type.
        """
        found: dict[str, list[RawMessage]] = {topic: [] for topic in topics}
        for message in self.raw(found):
            found[message.topic].append(message)
        data = {
            topic: [one.data for one in sorted(some, key=attrgetter("place"))]
            for topic, some in found.items()
        }
        try:
            return {topic: rows_of_messages(data[topic], SIGNALS[self.topics[topic]]) for topic in data}
        except BadMessageError as bad:
            for _ in self.signals(data):  # names the message in its error
                pass
            raise BagError(f"bag {self.path}: {bad}") from bad
