"""Repeated and wrong stamps, under which a block keeps its memory.

A block that has processed a tick returns the same output again. Late stamps and ones too far ahead are those
of q2q_model.signals.clock_resets.
"""

from math import inf
from typing import TypeGuard, TypeVar

from q2q_model.signals.clock_resets import AHEAD_S, ClockResetDetector
from q2q_model.signals.layout import Signal
from q2q_model.signals.values import Names

S = TypeVar("S", bound=Signal)


def is_repeated(last: S | None, t: float, names: Names) -> TypeGuard[S]:
    """Return whether a block's last output is that of the tick at t [s] for the vehicles `names`."""
    return last is not None and last.t == t and last.names == names


class StampOrder:
    """Newest stamp, which goes back, or far ahead, only where the clock is set.

    A clock that was set back is that of the first of its old stamps: the time for which they have risen by
    when that is known has passed, as in lost ticks. Others are left out, however old: followed at once, two
    frames that are 1.5 or 3 s late move the setpoints of table6 by up to 0.25 m in a tick.
    """

    def __init__(self) -> None:
        """Start before the first stamp."""
        self.reset()

    def reset(self) -> None:
        """Forget the stamps; the next one is the first."""
        self._newest = -inf
        self._old = ClockResetDetector()
        self.was_set = False
        """Whether the clock was set by the last stamp."""
        self.set_back = 0.0
        """By how much it was set back then [s]; 0 if it was not."""

    def reject_stamp(self, t: float) -> bool:
        """Take a stamp t [s]; return whether it is rejected: late, or too far ahead, of the same clock."""
        newest, old = self._newest, self._old
        self.was_set, self.set_back = False, 0.0
        if newest > -inf and not 0.0 <= t - newest <= AHEAD_S:
            if not old.confirm_reset(t) if t < newest else old.reject_ahead(t, newest):
                return True
            self.was_set, self.set_back = True, newest - old.first if t < newest else 0.0
        self._newest = t
        old.reset()
        return False
