"""Count pings that come back, as the quality of a link whose driver tells none (cflib's UDP driver).

cflib pings every vehicle ten times a second (link_statistics), over any link.
"""

import math
from collections import deque

WINDOW = 20
"""Pings counted: 2 s."""


class PingShare:
    """The last pings, and which of them came back."""

    def __init__(self) -> None:
        self._came_back: deque[bool] = deque(maxlen=WINDOW + 1)
        self._early = False  # an answer has overtaken the note of its ping

    def sent(self) -> None:
        """Note that a ping has been sent."""
        self._came_back.append(self._early)
        self._early = False

    def answered(self) -> None:
        """Note that the newest ping without an answer has come back."""
        for k in reversed(range(len(self._came_back))):
            if not self._came_back[k]:
                self._came_back[k] = True
                return
        self._early = True

    @property
    def share(self) -> float:
        """Return the share that came back; NaN before the second ping, as the newest is on its way."""
        older = list(self._came_back)[:-1]
        return sum(older) / len(older) if older else math.nan
