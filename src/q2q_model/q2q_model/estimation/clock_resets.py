"""Tell a clock that was set back from frames that come late, by the old stamps themselves.

Late frames are few, or out of order: a newer one comes between. Old stamps that rise and rise, CONFIRM_STAMPS
of them and for PATIENCE_S, are the new time.
"""

from math import inf

CONFIRM_STAMPS = 3
"""A clock was set back after at least as many old stamps in order, whatever their rate."""

ROUNDING = 1e-9
"""Of stamps in float64 [s]."""
PATIENCE_S = 0.1
"""For how long they must have risen [s]: a command is held for no longer (q2q_control.failsafe.ladder), and
frames that a network holds back come in shorter bursts."""


class ClockResetDetector:
    """Old stamps since the last newer one."""

    def __init__(self) -> None:
        """Know none."""
        self.reset()

    def reset(self) -> None:
        """Forget them: a newer stamp has come."""
        self._first, self._last, self._count = inf, inf, 0

    def rise(self, t: float) -> bool:
        """Take an old stamp t [s]; return whether old stamps have risen for long enough."""
        if not t > self._last:
            self._first, self._count = t, 0
        self._last = t
        self._count += 1
        return self._count >= CONFIRM_STAMPS and t - self._first >= PATIENCE_S - ROUNDING
