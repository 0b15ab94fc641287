"""Detection of a clock that was set back, as opposed to late frames.

Late frames are few, or newer ones come in between. Old stamps that increase CONFIRM_STAMPS times in a row and
for PATIENCE_S are the new time.
"""

from math import inf

CONFIRM_STAMPS = 3
"""Least number of old stamps in order, whatever their rate."""

ROUNDING = 1e-9
"""Rounding of stamps in float64 [s]."""
PATIENCE_S = 0.1
"""Time for which they must have increased [s]: the longest hold of a command (q2q_control.failsafe.ladder),
and longer than the bursts in which a network delivers delayed frames."""


class ClockResetDetector:
    """Old stamps since the last newer one."""

    def __init__(self) -> None:
        """Start without old stamps."""
        self.reset()

    def reset(self) -> None:
        """Forget the old stamps: a newer one has come."""
        self._first, self._last, self._count = inf, inf, 0

    def rise(self, t: float) -> bool:
        """Take an old stamp t [s]; return whether old stamps have increased for long enough."""
        if not t > self._last:
            self._first, self._count = t, 0
        self._last = t
        self._count += 1
        return self._count >= CONFIRM_STAMPS and t - self._first >= PATIENCE_S - ROUNDING
