"""In-process transport of signals between the nodes of one process (`ros2 run q2q_sim stack`).

Signals are delivered in the order of posting. A signal with listeners is published on ROS only after all
deliveries; one without listeners, such as the command at the end of the chain, is published at once. The
command therefore does not wait for the publication of intermediate signals.
A topic from another process is subscribed to once and posted to all listeners.
"""

from collections import defaultdict, deque
from collections.abc import Callable, Collection

from q2q_model.signals.layout import Signal

Listener = Callable[[int, Signal], None]
"""Callback that takes stamp [ns] and signal."""


def _do_not_publish() -> None:
    """Do not republish a signal from another process."""


class LocalBus:
    """Listeners of each topic that is published within the process."""

    def __init__(self, topics: Collection[str]) -> None:
        """Set the topics whose publishers are in this process."""
        self._topics = frozenset(topics)
        self._subscribed: set[str] = set()
        self._listeners: dict[str, list[Listener]] = defaultdict(list)
        self._waiting: deque[tuple[str, int, Signal]] = deque()
        self._later: list[Callable[[], None]] = []

    def carries(self, topic: str) -> bool:
        """Return whether a topic's publisher is in this process."""
        return topic in self._topics

    def claim_subscription(self, topic: str) -> bool:
        """Claim the subscription of an external topic; return whether the caller is the first."""
        known = topic in self._topics or topic in self._subscribed
        self._subscribed.add(topic)
        return not known

    def listen(self, topic: str, take: Listener) -> None:
        """Register `take(stamp_ns, signal)` for every signal posted on a topic."""
        self._listeners[topic].append(take)

    def post(
        self, topic: str, stamp_ns: int, signal: Signal, publish: Callable[[], None] = _do_not_publish
    ) -> None:
        """Deliver a signal; call `publish` at once if it has no listener, else after all deliveries."""
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
