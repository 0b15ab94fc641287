"""Predictions of a node's own vehicles that come from another node, which then flies them, too.

A node receives each prediction that it has sent once. One more of the same stamp, or one of another stamp, is
another node's.
"""

from collections import deque
from collections.abc import Iterable

from q2q_model.signals.values import Names

KEPT = 1000
"""Stamps of sent predictions not received yet: 10 s of them at 100 Hz; the first ones may find no reader."""


class OwnPredictions:
    """Stamps of the predictions that a node has sent and not received, and vehicles that others predict."""

    def __init__(self) -> None:
        """Start without predictions."""
        self._sent: deque[int] = deque(maxlen=KEPT)
        self._conflicts: set[str] = set()

    def send(self, stamp_ns: int) -> None:
        """Take the stamp of a prediction that the node sends [ns]."""
        self._sent.append(stamp_ns)

    def receive(self, stamp_ns: int, names: Iterable[str]) -> None:
        """Take the stamp of a prediction of own vehicles that the node receives [ns], and these vehicles."""
        if stamp_ns in self._sent:
            self._sent.remove(stamp_ns)
        else:
            self._conflicts.update(names)

    def take_conflicts(self) -> Names:
        """Return the own vehicles that others have predicted since the last call."""
        conflicts = tuple(sorted(self._conflicts))
        self._conflicts.clear()
        return conflicts
