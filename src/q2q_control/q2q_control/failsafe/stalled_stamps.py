"""Time for which the stamps of frames do not rise, counted by frames.

In lockstep stamps are the only clock, so that a frame that is published again has to get the same answer. One
that comes again and again, or stamps that went back, show a stalled clock while vehicles fly on:
every such frame counts as a tick. Live, the wall clock counts (q2q_control.failsafe.input_deadline).
"""

from math import inf

from q2q_model.signals.stamps import TICK_S


class StalledStamps:
    """Frames since that of the newest stamp."""

    def __init__(self) -> None:
        self._newest, self._frames = -inf, 0

    def update(self, newest: float) -> float:
        """Take a frame that is not newer than `newest` [s]; return for how long that is the newest [s]."""
        self._frames = self._frames + 1 if newest == self._newest else 1
        self._newest = newest
        return self._frames * TICK_S
