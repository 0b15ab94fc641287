"""Clock of a replanner's ticks: which of them are late."""

from math import inf

from q2q_model.estimation.clock_resets import ClockResetDetector
from q2q_planner.online.replanner import LONGEST_GAP


class TickClock:
    """Newest stamp of the ticks, which goes back only where their clock is set back."""

    def __init__(self) -> None:
        """Start before the first tick."""
        self.reset()

    def reset(self) -> None:
        """Forget the ticks; the next one is the first."""
        self._newest = -inf
        self._old = ClockResetDetector()

    def is_late(self, t: float) -> bool:
        """Take the stamp of a tick [s]; return whether it is older than one before, of the same clock."""
        back = self._newest - t
        if 0.0 < back <= LONGEST_GAP and not self._old.rise(t):
            return True
        self._newest = t
        self._old.reset()
        return False
