"""Schedule of a playback: bag time to wall time."""

from dataclasses import dataclass, replace

PAUSE_S = 1.0
"""Time without a look for due messages [s] that is a pause, not to be caught up in a burst."""
MOMENT_S = 1.0
"""Round of a loop over a bag without duration [s], such as one of a single plan."""


@dataclass(frozen=True, slots=True)
class Playback:
    """Offset and rate between bag time and wall time."""

    first_ns: int
    """Bag time of the first message to play [ns]."""
    began: float
    """Wall time of the first message [s]."""
    rate: float
    """Bag seconds per wall second."""

    def due(self, stamp_ns: int) -> float:
        """Return the wall time of a message with this bag time [s]."""
        return self.began + (stamp_ns - self.first_ns) * 1e-9 / self.rate

    def after_pause(self, pause: float) -> "Playback":
        """Return the playback that goes on where it was before a pause [s], as of a stopped process."""
        return replace(self, began=self.began + pause)

    def next_round(self, last_ns: int, now: float) -> "Playback":
        """Return the next round of a loop whose last message has this bag time [ns]."""
        return replace(self, began=now + (MOMENT_S if last_ns <= self.first_ns else 0.0))
