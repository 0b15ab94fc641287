"""Rate limit of a stamped stream."""


class Decimation:
    """Rate limiter that passes at most `rate_hz` events per second of stamp time."""

    def __init__(self, rate_hz: float) -> None:
        """Set the largest rate [Hz]; 0 blocks all events."""
        self._period = 1.0 / rate_hz if rate_hz > 0.0 else float("inf")
        self._next = float("-inf") if rate_hz > 0.0 else float("inf")

    def __call__(self, t: float) -> bool:
        """Return whether the event at time t [s] passes; a backward time jump restarts the limiter."""
        if t < self._next and t > self._next - 2.0 * self._period:
            return False
        if self._period == float("inf"):
            return False
        self._next = t + self._period * (1.0 - 1e-6)
        return True
