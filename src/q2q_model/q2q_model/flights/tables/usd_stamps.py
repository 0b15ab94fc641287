"""Times of the rows of a micro-SD log from their stamps: counters that wrap, and stamps that are damaged.

A damaged byte changes one stamp. Its neighbours rise without it, so the row is dropped, and not the rows
whose times do not rise after it. Of rows with equal stamps, the first is kept.
"""

import numpy as np
from numpy.typing import NDArray

from q2q_model.signals.values import Array, Mask

LONGEST_PAUSE_S = 60.0
"""Longest time between the first or last row and the next to it [s]: a log has no single row so far away."""


def stamped_times(stamps: NDArray[np.generic], unit: float) -> Array:
    """Return stamps in units of `unit` [s] as times [s], (T,).

    A counter of 32 bits or fewer goes on where it wraps: one of microseconds does so after 71.6 minutes.
    """
    counts = stamps.astype(np.float64)
    if stamps.dtype.kind == "u" and stamps.dtype.itemsize <= 4:
        counts = np.unwrap(counts, period=2.0 ** (8 * stamps.dtype.itemsize))
    return np.asarray(counts * unit)


def rising_rows(t: Array) -> NDArray[np.intp]:
    """Return rows of t (m,) [s] with rising times, one of each, none outside the times of its neighbours."""
    rows = np.flatnonzero(~_out_of_order(t))
    rows = rows[np.diff(np.maximum.accumulate(t[rows]), prepend=-np.inf) > 0.0]
    if len(rows) > 1 and t[rows[-1]] - t[rows[-2]] > LONGEST_PAUSE_S:
        rows = rows[:-1]
    if len(rows) > 1 and t[rows[1]] - t[rows[0]] > LONGEST_PAUSE_S:
        rows = rows[1:]
    return rows


def _out_of_order(t: Array) -> Mask:
    """Return the rows without which their neighbours are in order, and with which they are not, (T,).

    Equal times are in order. Of two swapped rows, either of which would do, it is the first.
    """
    found = np.zeros(len(t), dtype=np.bool_)
    if len(t) > 2:
        before, own, after = t[:-2], t[1:-1], t[2:]
        found[1:-1] = (before <= after) & ~((before <= own) & (own <= after))
        found[0] = t[1] <= t[2] <= t[0] != t[1]
    for row in np.flatnonzero(found)[1:]:
        found[row] &= not found[row - 1]
    return found
