"""Autocovariance of rows that are not all known, as sums over blocks of products of two rows a lag apart."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from q2q_model.signals.values import Array, Mask


class Products(NamedTuple):
    """Pairs of known rows one lag apart."""

    first: NDArray[np.intp]
    """Index of the earlier row, (m,)."""
    second: NDArray[np.intp]


def lagged_pairs(known: Mask, lag: int) -> Products:
    """Return the pairs of known rows `lag` ticks apart."""
    first = np.flatnonzero(known[: known.size - lag] & known[lag:])
    return Products(first, first + lag)


def autocovariance(values: Array, known: Mask, lags: NDArray[np.intp]) -> Array:
    """Return the mean product of known values at each lag in ticks, (L,); 0 without pairs."""
    found = np.zeros(lags.size)
    for k, lag in enumerate(lags):
        first, second = lagged_pairs(known, int(lag))
        if first.size:
            found[k] = float(np.mean(values[first] * values[second]))
    return found


def lag_ticks(t: Array, times: Array) -> NDArray[np.intp]:
    """Return lags [s] in ticks of t, at least one apart."""
    return np.unique(np.rint(times / float(np.median(np.diff(t)))).astype(np.intp))
