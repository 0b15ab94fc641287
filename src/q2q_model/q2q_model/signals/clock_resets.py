"""Detection of a clock that was set back or ahead, as opposed to late frames and wrong stamps.

Late frames are few, or newer ones come in between. Old stamps are those of a clock that was set back once the
newest of them has increased CONFIRM_STAMPS times and for CONFIRM_S, also if frames between them come in
another order. A frame of the time before, which is late or delivered again, does not count: its stamp is
nearer to those before. Stamps further ahead than AHEAD_S are wrong, unless they go on from there for
CONFIRM_S, as after a gap.
"""

from math import inf

from q2q_model.signals.stamps import SAME_INSTANT

CONFIRM_STAMPS = 3
"""Minimum number of old stamps in order, whatever their rate."""
SET_BACK_S = 1.0
"""Step back of a clock beyond which another flight begins, unless set otherwise [s]."""
AHEAD_S = 1.0
"""Step ahead beyond which a stamp may be wrong [s]. A wrong one that is ahead by less ages all states by its
step until old stamps have risen and tracks are found again, for 0.3 s at most; by 0.8 s or more, vehicles
land meanwhile (land_after_s of q2q_control.failsafe.fallback_phases)."""
CONFIRM_S = 0.1
"""Time for which old stamps, or those far ahead, must have increased [s]: as long as a command holds
(q2q_control.failsafe.fallback_params), and longer than the bursts in which a network delivers frames."""


class ClockResetDetector:
    """Old stamps, and those far ahead, since the last newer one."""

    def __init__(self) -> None:
        """Start without stamps."""
        self.reset()

    def reset(self) -> None:
        """Forget these stamps: a newer one has come."""
        self._ahead = inf  # oldest of those far ahead
        self._first, self._newest, self._count = inf, inf, 0
        self._before = inf  # newest of the old stamps before they went back
        self._was_late = False

    @property
    def first(self) -> float:
        """Return the oldest of the old stamps [s]; infinite without one."""
        return self._first

    def reject_ahead(self, t: float, newest: float) -> bool:
        """Take a stamp t [s] that may be newer; return whether it is too far ahead of `newest` [s].

        It is not once stamps have gone on from there for long enough: at a low rate, with the second one.
        """
        if not t - newest > AHEAD_S:
            return False
        self._ahead = min(self._ahead, t)
        return t - self._ahead < CONFIRM_S - SAME_INSTANT

    def confirm_reset(self, t: float) -> bool:
        """Take an old stamp t [s]; return whether the newest of them has increased for long enough."""
        if t < self._first:
            self._before = self._newest
            self._first = self._newest = t
            self._count = 1
        elif t > self._newest and t != self._before:
            self._was_late = self._is_late(t)
            if not self._was_late:
                self._newest = t
                self._count += 1
        return self._count >= CONFIRM_STAMPS and self._newest - self._first >= CONFIRM_S - SAME_INSTANT

    def _is_late(self, t: float) -> bool:
        """Return whether a stamp is of the time before; two in a row are not: frames may have been lost."""
        return not self._was_late and abs(t - self._before) < t - self._newest
