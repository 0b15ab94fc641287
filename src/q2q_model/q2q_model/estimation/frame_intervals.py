"""Intervals between frames, and the longest one after which motion capture may still be said to go on."""

from collections import deque

from q2q_model.estimation.association.jump_candidates import GAP_S

COUNT = 5
"""Intervals of which the shortest is the period of the frames: some frames may be lost."""
PERIODS = 1.5
"""Periods within which the next frame comes if none is lost [-]."""


class FrameIntervals:
    """Last intervals between frames."""

    def __init__(self) -> None:
        self._last: deque[float] = deque(maxlen=COUNT)
        self.period = 0.0
        """Period of the frames [s]; 0 until it is known."""
        self.longest = GAP_S
        """Longest interval that is no gap [s]."""

    def add(self, interval: float) -> None:
        """Add the interval before a frame [s]."""
        self._last.append(interval)
        if len(self._last) == COUNT:
            self.period = min(self._last)
            self.longest = max(GAP_S, PERIODS * self.period)
