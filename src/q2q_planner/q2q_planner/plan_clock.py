"""Remember when a plan starts: at a given stamp, or at the first tick seen."""


class PlanClock:
    """Hold the start of a plan that is being played."""

    def __init__(self, start: float) -> None:
        """Take the start [s]; below zero means the first tick."""
        self.start = start
        """Start of the plan [s]; below zero before the first tick."""
        self._told = False

    @property
    def start_ns(self) -> int:
        """Return the start [ns]."""
        return round(self.start * 1e9)

    def starts_with(self, t: float) -> bool:
        """Return True once, at the first tick t [s]; from then on `start` is set."""
        first = not self._told
        self._told = True
        if first and self.start < 0.0:
            self.start = t
        return first
