"""Remember when a plan starts: at a given stamp, or at the first tick seen."""


class PlanClock:
    """Hold the start of a plan that is being played."""

    def __init__(self, start: float) -> None:
        """Take the start [s]; below zero means the first tick."""
        self.start = start
        """Start of the plan [s]; below zero before the first tick."""
        self._known = start >= 0.0

    @property
    def start_ns(self) -> int:
        """Return the start [ns]."""
        return round(self.start * 1e9)

    def starts_with(self, t: float) -> bool:
        """Return True at the first tick t [s] where no start was given; from then on `start` is set."""
        if self._known:
            return False
        self.start, self._known = t, True
        return True
