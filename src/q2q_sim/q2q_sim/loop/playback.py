"""Say when each message of a bag is due when it is played: at a rate, from a start."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Playback:
    """Offset and rate between bag time and wall time."""

    first_ns: int
    """Bag time of the first message to play [ns]."""
    began: float
    """Wall time at which it is played [s]."""
    rate: float
    """Bag seconds a wall second."""

    def due(self, stamp_ns: int) -> float:
        """Return the wall time at which a message of this bag time is due [s]."""
        return self.began + (stamp_ns - self.first_ns) * 1e-9 / self.rate
