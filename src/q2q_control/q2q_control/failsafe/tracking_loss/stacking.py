"""Pairs of vehicles of which one is above the other."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array, Rows


class Stacked(NamedTuple):
    """Pairs of rows, (p,) each."""

    below: Rows
    above: Rows


def stacked_pairs(pos: Array, below: Rows, reach: float, gap: float) -> Stacked:
    """Return who is above some vehicles, in the order of these.

    Args:
        pos: of all vehicles [m], world, (n, 3); nobody is above or below an unknown one (NaN).
        below: rows of those that may be below another, (m,).
        reach: horizontal distance within which one is above another [m].
        gap: least height difference [m].
    """
    lower, above = np.nonzero(is_above(np.ascontiguousarray(pos), below, reach, gap))
    return Stacked(below[lower], above)


@compiled
def is_above(pos: Array, below: Rows, reach: float, gap: float) -> NDArray[np.bool_]:
    """Return for each of `below` (m,) who is above it, (m, n); arguments as of `stacked_pairs`."""
    over = np.zeros((below.size, pos.shape[0]), dtype=np.bool_)
    for k in range(below.size):
        x, y, z = pos[below[k]]
        for j in range(pos.shape[0]):
            across, aside = pos[j, 0] - x, pos[j, 1] - y
            near = across * across + aside * aside < reach * reach
            over[k, j] = near and pos[j, 2] - z > gap
    return over
