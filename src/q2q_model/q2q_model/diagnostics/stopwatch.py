"""Stopwatch on an injected clock, for `/diagnostics`."""

from collections.abc import Callable, Mapping


class Stopwatch:
    """Start, last lap and longest lap of a repeated task."""

    def __init__(self, clock: Callable[[], float]) -> None:
        """Start on a monotonic clock [s]."""
        self._clock = clock
        self.last = self.longest = 0.0
        """Laps [s]."""
        self.restart()

    def restart(self) -> None:
        """Restart; laps are kept."""
        self._begin = self._clock()

    def seconds(self) -> float:
        """Return the time since the start [s]."""
        return self._clock() - self._begin

    def lap(self) -> None:
        """Record the time since the start as a lap."""
        self.last = self.seconds()
        self.longest = max(self.longest, self.last)

    def take_lap_report(self) -> Mapping[str, str]:
        """Return the last lap and the longest since the last report, as diagnostic values."""
        laps = {"compute_ms": f"{1e3 * self.last:.3g}", "compute_max_ms": f"{1e3 * self.longest:.3g}"}
        self.longest = 0.0
        return laps
