"""Let through at most so many events a second, by the stamps of the events."""


class Decimation:
    """Time at which the last event passed."""

    def __init__(self, rate_hz: float) -> None:
        """Take the largest rate [Hz]; 0 lets nothing through."""
        self._period = 1.0 / rate_hz if rate_hz > 0.0 else float("inf")
        self._next = float("-inf") if rate_hz > 0.0 else float("inf")

    def __call__(self, t: float) -> bool:
        """Return whether the event at time t [s] goes through; a jump back in time starts anew."""
        if t < self._next and t > self._next - 2.0 * self._period:
            return False
        if self._period == float("inf"):
            return False
        self._next = t + self._period * (1.0 - 1e-6)
        return True
