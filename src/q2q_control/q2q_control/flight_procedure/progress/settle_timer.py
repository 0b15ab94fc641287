"""Time for which a condition has held."""

from math import inf


class SettleTimer:
    """Time since which a condition holds."""

    def __init__(self, settle_s: float) -> None:
        """Call a condition settled once it has held for settle_s [s]."""
        self._settle_s = settle_s
        self._since = inf

    def update(self, holds: bool, t: float) -> bool:
        """Return whether the condition, which holds at t [s] or not, is settled."""
        self._since = min(self._since, t) if holds else inf
        return t - self._since >= self._settle_s

    def reset(self) -> None:
        """Start again."""
        self._since = inf
