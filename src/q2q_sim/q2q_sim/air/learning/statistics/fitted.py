"""Learned terms with the interval, the rows and the source of each value."""

import math
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

from q2q_sim.air.learning.statistics.block_bootstrap import Spread

T = TypeVar("T")
AT_BOUND = 2e-3
"""Share of its range within which a value is at the bound of its search."""


@dataclass(frozen=True, slots=True)
class Fitted:
    """Learned value."""

    path: str
    """Its place in a RoomAir, such as "residual.time_s"."""
    value: float
    low: float | None
    """Ends of the 95 % interval; None where the rows give none, or at the bound of the search."""
    high: float | None
    rows: int
    """Rows, or flights of vehicles, that it was learned from."""
    source: str

    @property
    def ends(self) -> tuple[float, float] | None:
        """Return both ends of the interval; None where it is unknown."""
        return None if self.low is None or self.high is None else (self.low, self.high)


@dataclass(frozen=True, slots=True)
class LearnedTerm(Generic[T]):
    """Term of an air and its values."""

    term: T
    values: tuple[Fitted, ...]


def fitted_value(spread: Spread, k: int, path: str, rows: int, source: str) -> Fitted:
    """Return value k of a bootstrap."""
    low, high = (float(end[k]) for end in (spread.low, spread.high))
    known = math.isfinite(low) and math.isfinite(high)
    return Fitted(path, float(spread.value[k]), low if known else None, high if known else None, rows, source)


def within_search(one: Fitted, bounds: tuple[float, float]) -> Fitted:
    """Return a value, without interval if it is at a bound of its search, as the optimum may lie beyond."""
    if min(abs(one.value - end) for end in bounds) > AT_BOUND * (bounds[1] - bounds[0]):
        return one
    return replace(one, low=None, high=None, source=f"{one.source}; at the bound of its search")
