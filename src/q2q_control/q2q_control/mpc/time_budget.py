"""Time budget of a tick's computation."""

from collections.abc import Callable
from math import inf


class TimeBudget:
    """Deadline of a tick's computation."""

    def __init__(self, seconds: float, clock: Callable[[], float]) -> None:
        """Allow `seconds` a tick, by a monotonic clock [s]."""
        self._seconds = seconds
        self._clock = clock
        self._end = inf

    def begin(self) -> None:
        """Start the budget of a tick."""
        self._end = self._clock() + self._seconds

    def in_time(self) -> bool:
        """Return whether time is left; True before the first tick."""
        return self._clock() < self._end
