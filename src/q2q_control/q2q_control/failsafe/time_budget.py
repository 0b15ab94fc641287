"""Say whether a tick's computing is still in time, by a clock that is handed in."""

from collections.abc import Callable
from math import inf


class TimeBudget:
    """Computing time that is left in a tick."""

    def __init__(self, seconds: float, clock: Callable[[], float]) -> None:
        """Allow so many seconds a tick, by a clock [s] that only grows."""
        self._seconds = seconds
        self._clock = clock
        self._end = inf

    def begin(self) -> None:
        """Begin a tick."""
        self._end = self._clock() + self._seconds

    def in_time(self) -> bool:
        """Return whether time is left; without a tick begun, there is."""
        return self._clock() < self._end
