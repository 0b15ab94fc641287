"""Link quality as the share of answered pings, for a driver that reports none (cflib's UDP driver).

The link pings its vehicle ten times per second (q2q_control.radio.link.cflib_link).
"""

import math
from collections import deque

WINDOW = 20
"""Pings counted: 2 s."""


class PingShare:
    """Window of the last pings, and which were answered."""

    def __init__(self) -> None:
        self._answered: deque[bool] = deque(maxlen=WINDOW + 1)
        self._early = False  # an answer was counted before its ping

    def sent(self) -> None:
        """Count a ping."""
        self._answered.append(self._early)
        self._early = False

    def answered(self) -> None:
        """Count an answer, to the newest ping without one."""
        for k in reversed(range(len(self._answered))):
            if not self._answered[k]:
                self._answered[k] = True
                return
        self._early = True

    @property
    def share(self) -> float:
        """Return the answered share; NaN before the second ping, as the newest may still be answered."""
        older = list(self._answered)[:-1]
        return sum(older) / len(older) if older else math.nan
