"""Rate limit of a stamped stream."""

from math import inf

EARLY = 1e-6
"""Part of the period by which an event may come early [-]: stamps are rounded."""


class Decimation:
    """Rate limiter that passes at most `rate_hz` events per second of stamp time."""

    def __init__(self, rate_hz: float) -> None:
        """Set the largest rate [Hz]; 0 blocks all events."""
        self._period = 1.0 / rate_hz if rate_hz > 0.0 else inf
        self._next = -inf

    def __call__(self, t: float) -> bool:
        """Return whether the event at time t [s] passes; a backward time jump restarts the limiter."""
        if self._period == inf or self._next - 2.0 * self._period < t < self._next:
            return False
        self._next = t + self._period * (1.0 - EARLY)
        return True
