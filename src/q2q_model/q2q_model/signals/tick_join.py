"""Join of a tick's inputs by stamp.

A tick is complete when every topic has delivered a value with its stamp. Completing a tick drops all older
incomplete ones and counts them as missed, each once: a part of a tick that was complete, or is counted, may
come again and is not counted.
"""

from collections import OrderedDict, deque
from typing import Generic, TypeVar

V = TypeVar("V")

WAITING_TICKS = 16
"""Incomplete ticks kept, and settled ones remembered (0.16 s at 100 Hz, longer than any useful delay); older
ones are dropped."""


class TickJoin(Generic[V]):
    """Join of several topics by stamp."""

    def __init__(self, topics: tuple[str, ...], waiting: int = WAITING_TICKS) -> None:
        """Create the join.

        Args:
            topics: inputs of a tick.
            waiting: incomplete ticks kept; a reader with a longer queue keeps as many as the queue holds.
        """
        self._topics, self._keep = topics, waiting
        self._waiting: OrderedDict[int, dict[str, V]] = OrderedDict()
        self._settled: deque[int] = deque(maxlen=WAITING_TICKS)  # complete, or counted as missed
        self.missed = 0
        """Ticks dropped incomplete."""

    def put(self, topic: str, stamp_ns: int, value: V) -> tuple[V, ...] | None:
        """Add a value; return the tick's values in the order of the topics once it is complete."""
        tick = self._waiting.setdefault(stamp_ns, {})
        tick[topic] = value
        if len(tick) < len(self._topics):
            self._give_up()
            return None
        del self._waiting[stamp_ns]
        self._settled.append(stamp_ns)
        if self._waiting:
            self._drop_older_than(stamp_ns)
        return tuple(map(tick.__getitem__, self._topics))

    def lacking(self) -> str:
        """Return what the incomplete ticks lack, in words."""
        come = {topic for tick in self._waiting.values() for topic in tick}
        absent = [topic for topic in self._topics if topic not in come]
        if absent:
            received = f", {', '.join(sorted(come))} received" if come else ""
            return f"{', '.join(absent)} not received{received}"
        return f"{', '.join(self._topics)} received, never with the same stamp"

    def reset(self) -> None:
        """Drop every incomplete tick."""
        self._waiting.clear()
        self._settled.clear()

    def _drop_older_than(self, stamp_ns: int) -> None:
        for old in [stamp for stamp in self._waiting if stamp < stamp_ns]:
            del self._waiting[old]
            self._count(old)

    def _give_up(self) -> None:
        while len(self._waiting) > self._keep:
            self._count(self._waiting.popitem(last=False)[0])

    def _count(self, stamp_ns: int) -> None:
        """Count a dropped tick, unless it is settled."""
        if stamp_ns not in self._settled:
            self._settled.append(stamp_ns)
            self.missed += 1
