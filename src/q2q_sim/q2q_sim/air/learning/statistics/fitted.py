"""Learned terms with the interval, the rows and the source of each value."""

import math
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

from q2q_sim.air.learning.statistics.block_bootstrap import Spread

T = TypeVar("T")
AT_BOUND = 0.01
"""Share of a bound within which a value is at it: fits end up to 0.8 % from it, steps of grids are 2 %."""
ZERO = 1e-4
"""Share of the upper bound below which an end of an interval is 0: fits end up to 2e-5 of it above 0."""


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
    """Return a value, without interval if it is at a bound of its search, as the optimum may lie beyond.

    No value is below a lower bound of 0: there it has no interval only if the whole interval is 0.
    """
    return at_bound(one) if _is_at_bound(one, bounds) else one


def not_negative(one: Fitted) -> Fitted:
    """Return a value that is 0 at least, without its interval if that is 0, too."""
    return at_bound(one) if one.value == 0.0 == one.high else one


def at_bound(one: Fitted) -> Fitted:
    """Return a value at a bound of its search, without its interval."""
    return replace(one, low=None, high=None, source=f"{one.source}; at the bound of its search")


def _is_at_bound(one: Fitted, bounds: tuple[float, float]) -> bool:
    low, high = bounds
    if any(abs(one.value - end) < AT_BOUND * end for end in bounds):
        return True
    return low == 0.0 and one.high is not None and one.high < ZERO * high
