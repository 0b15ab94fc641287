"""Hand signals from block to block within one process, before the rest of the world gets them.

Nodes that share a process (`ros2 run q2q_sim stack`) need no transport between them. A posted signal is given
to its listeners in turn, what they post in the order it was posted, and only then is published what had a
listener; a signal without one, as the command at the end of the road, is published at once. So whoever waits
for the command does not wait for the publication of what led to it. A topic that comes from outside is read
once, and posted for all who listen.
"""

from collections import defaultdict, deque
from collections.abc import Callable, Collection

from q2q_model.signals.layout import Signal

Listener = Callable[[int, Signal], None]
"""Takes stamp [ns] and signal."""


def _nothing() -> None:
    """Leave a signal from outside unpublished."""


class LocalBus:
    """Listeners of every topic that is written within the process."""

    def __init__(self, topics: Collection[str]) -> None:
        """Take the topics whose writers are in this process."""
        self._topics = frozenset(topics)
        self._admitted: set[str] = set()
        self._listeners: dict[str, list[Listener]] = defaultdict(list)
        self._waiting: deque[tuple[str, int, Signal]] = deque()
        self._later: list[Callable[[], None]] = []

    def carries(self, topic: str) -> bool:
        """Return whether a topic's writer is in this process."""
        return topic in self._topics

    def admits(self, topic: str) -> bool:
        """Return whether the caller must read a topic from outside: it is nobody's yet."""
        known = topic in self._topics or topic in self._admitted
        self._admitted.add(topic)
        return not known

    def listen(self, topic: str, take: Listener) -> None:
        """Have `take(stamp_ns, signal)` called for every signal posted on a topic."""
        self._listeners[topic].append(take)

    def post(self, topic: str, stamp_ns: int, signal: Signal, publish: Callable[[], None] = _nothing) -> None:
        """Give a signal to its listeners; call `publish` at once if there are none, else once all is calm."""
        if not self._listeners[topic]:
            publish()
            return
        self._later.append(publish)
        self._waiting.append((topic, stamp_ns, signal))
        if len(self._waiting) == 1:
            self._deliver()

    def _deliver(self) -> None:
        try:
            while self._waiting:
                topic, stamp_ns, signal = self._waiting[0]
                for take in self._listeners[topic]:
                    take(stamp_ns, signal)
                self._waiting.popleft()
        finally:
            self._waiting.clear()
            later, self._later = self._later, []
            for publish in later:
                publish()
