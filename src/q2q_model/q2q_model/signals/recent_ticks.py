"""Memory of recent ticks, to find the one that a later signal belongs to by its stamp."""

from collections import deque
from typing import Generic, Protocol, TypeVar

import numpy as np

from q2q_model.signals.stamps import SAME_STAMP


class Stamped(Protocol):
    """Anything of a time."""

    @property
    def t(self) -> float:
        """Return the stamp [s]."""


S = TypeVar("S", bound=Stamped)


class RecentTicks(Generic[S]):
    """Ticks of the last `span` seconds, in their order."""

    def __init__(self, span: float) -> None:
        self._span = span
        self._ticks: deque[S] = deque()

    def reset(self) -> None:
        """Forget all ticks."""
        self._ticks.clear()

    @property
    def last(self) -> S | None:
        """Return the newest tick."""
        return self._ticks[-1] if self._ticks else None

    def is_over(self, t: float) -> bool:
        """Return whether a tick of t [s] or later has been remembered."""
        return t <= (self._ticks[-1].t if self._ticks else -np.inf) + SAME_STAMP

    def remember(self, tick: S) -> None:
        """Remember a tick and forget those older than the span."""
        self._ticks.append(tick)
        while self._ticks[0].t < tick.t - self._span:
            self._ticks.popleft()

    def at(self, t: float) -> S | None:
        """Return the tick of t [s]; None if it is not remembered."""
        return next((tick for tick in self._ticks if abs(tick.t - t) < SAME_STAMP), None)
