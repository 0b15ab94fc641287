"""Minimum of many functions of time by branch and bound, with a proven lower bound.

A stretch of time is given by the Bernstein control points of its motion, and bounded by a value that is taken
on it and by one that no value is below. Stretches whose lower bound is above the least value taken so far,
less a tolerance, are discarded; the others are halved (Land and Doig, An Automatic Method of Solving Discrete
Programming Problems, Econometrica 28, 1960, for the method).
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from q2q_model.signals.values import Array
from q2q_model.trajectory.bernstein import split_in_half
from q2q_planner.offline.certificate.rounding_bound import DEEPEST

TOLERANCE = 1e-5
"""How far a bound may lie below the true least value [m]."""

MOST_STRETCHES = 10_000_000
"""Stretches beyond which a plan is not searched further, for its memory: a hundred vehicles have a tenth."""


class StretchBounds(NamedTuple):
    """Bounds of the least value on each stretch, (m,) each."""

    upper: Array
    """A value that is taken on the stretch [m]."""
    share: Array
    """Where, from 0 at its begin to 1 at its end."""
    lower: Array
    """No value on the stretch is below this [m]."""


class Least(NamedTuple):
    """Minimum value of all stretches."""

    value: float
    """The least value found [m]."""
    row: int
    """The stretch on which it is taken."""
    share: float
    """Where, from 0 at its begin to 1 at its end."""
    bound: float = -np.inf
    """No value is below this [m]; within the tolerance if there were no more than MOST_STRETCHES."""


def least_on_stretches(
    points: Array,
    bounds: Callable[[Array], StretchBounds],
    tolerance: float = TOLERANCE,
    relative: float = 0.0,
    enough: float = -np.inf,
) -> Least:
    """Return the least value on stretches.

    Args:
        points: control points, (m, ..., order).
        bounds: bounds of the value, of such arrays.
        tolerance: how far the bound may lie below the true least value.
        relative: the same, as a share of it; added.
        enough: a value of this or less ends the search, without a bound.
    """
    row, share, length = np.arange(len(points)), np.zeros(len(points)), 1.0
    found, floor = Least(np.inf, 0, 0.0), np.inf
    for _ in range(DEEPEST):
        here = bounds(points)
        found = _improved(found, here, row, share + length * here.share)
        if found.value <= enough:
            return found
        split = here.lower < found.value - (tolerance + relative * abs(found.value))
        floor = min(floor, float(here.lower[~split].min(initial=np.inf)))
        if not split.any():
            return found._replace(bound=min(floor, found.value))
        points = np.concatenate(split_in_half(points[split]))
        length *= 0.5
        row = np.tile(row[split], 2)
        share = np.concatenate([share[split], share[split] + length])
        if len(row) > MOST_STRETCHES:
            break
    return found._replace(bound=min(floor, found.value, float(bounds(points).lower.min())))


def polynomial_bounds(points: Array) -> StretchBounds:
    """Return the bounds of polynomials of control points (m, order): the lower end, and the least point."""
    ends = points[:, [0, -1]]
    return StretchBounds(ends.min(1), ends.argmin(1).astype(float), points.min(1))


def _improved(found: Least, here: StretchBounds, row: np.ndarray, at: Array) -> Least:
    """Return the lower one of what was found before and the least value of these stretches."""
    i = int(here.upper.argmin())
    return Least(float(here.upper[i]), int(row[i]), float(at[i])) if here.upper[i] < found.value else found
