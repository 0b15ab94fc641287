"""Masks with a row per tick: the last tick up to each at which one was true, and its runs of True."""

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from q2q_model.signals.values import Array, Mask, Rows

Number = TypeVar("Number", np.float64, np.intp)


def last_time(mask: Mask, t: Array) -> Array:
    """Return the last time [s] of t (T,), up to each row, at which a mask (T, ...) was true, (T, ...).

    -inf before the first. Where t steps back, the latest of these times counts.
    """
    return np.maximum.accumulate(np.where(mask, _beside(t, mask), -np.inf), axis=0)


def last_row(mask: Mask) -> Rows:
    """Return the last row, up to each, at which a mask (T, ...) was true, (T, ...); -1 before the first."""
    return np.maximum.accumulate(np.where(mask, _beside(np.arange(len(mask)), mask), -1), axis=0)


def runs_of_true(mask: Mask) -> list[tuple[int, int]]:
    """Return begin and end of each run of True in (T,)."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], mask, [False])).astype(np.int8)))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))


def _beside(values: NDArray[Number], mask: Mask) -> NDArray[Number]:
    """Return values (T,) with an axis of length 1 for every further one of a mask (T, ...)."""
    return values.reshape(-1, *(1,) * (mask.ndim - 1))
