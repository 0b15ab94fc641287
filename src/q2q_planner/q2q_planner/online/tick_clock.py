"""Clock of a replanner's ticks: which of them are late, and by how much the clock was set back.

A clock that was set back is that of the first of its old stamps: the time for which they have risen by when
that is known (q2q_model.signals.clock_resets) has passed, as in lost ticks.

However old a stamp is, and also for one far ahead, it waits for those that go on from there: were the frame
late after all, motions that had followed it would be propagated by as much at the next tick. In table6, two
frames that are 1.5 or 3 s late would so move setpoints by up to 0.25 m in a tick; they move by 3 mm. If the
clock stays back, the wait costs a step of 0.1 s of motion, and changes smallest distances in table6 and
swarm6 by 2 cm at most.
"""

from math import inf

from q2q_model.signals.clock_resets import ClockResetDetector


class TickClock:
    """Newest stamp of the ticks, which goes back only where their clock is set back."""

    def __init__(self) -> None:
        """Start before the first tick."""
        self.reset()

    def reset(self) -> None:
        """Forget the ticks; the next one is the first."""
        self._newest = -inf
        self._old = ClockResetDetector()
        self.set_back = 0.0
        """By how much the clock was set back at the last tick [s]; 0 if it was not."""

    def is_late(self, t: float) -> bool:
        """Take the stamp of a tick [s]; return whether it is older, or too far ahead, of the same clock."""
        self.set_back = 0.0
        if self._newest > -inf and self._old.is_ahead(t, self._newest):
            return True
        if t < self._newest:
            if not self._old.rise(t):
                return True
            self.set_back = self._newest - self._old.first
        self._newest = t
        self._old.reset()
        return False
