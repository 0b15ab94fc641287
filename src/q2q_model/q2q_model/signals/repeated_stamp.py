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
    """Newest stamp, which goes back, or far ahead, only where the clock is set."""

    def __init__(self) -> None:
        """Start before the first stamp."""
        self._newest = -inf
        self._old = ClockResetDetector()
        self.was_set = False
        """Whether the clock was set by the last stamp."""

    def is_wrong(self, t: float) -> bool:
        """Take a stamp t [s]; return whether it is late, or too far ahead, of the same clock."""
        newest = self._newest
        is_off = newest > -inf and not 0.0 <= t - newest <= AHEAD_S
        if is_off and (not self._old.rise(t) if t < newest else self._old.is_ahead(t, newest)):
            self.was_set = False
            return True
        self._newest, self.was_set = t, is_off
        self._old.reset()
        return False
