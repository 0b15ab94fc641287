"""Playback schedule of a bag: offset and rate between bag time and wall time."""

from dataclasses import dataclass


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
