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


class Lags(NamedTuple):
    """Lags of a flight, none of which is there twice."""

    ticks: NDArray[np.intp]
    """(L,), ascending."""
    times: Array
    """The same [s], in whole milliseconds: flights of one rate share their lags, (L,)."""


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


def flight_lags(t: Array, times: Array) -> Lags:
    """Return the lags of a flight with stamps t [s] that are nearest to `times` [s], (K,).

    A slow flight has fewer than K, at other times. Only a lag of 0 is shorter than a tick.
    """
    tick = float(np.median(np.diff(t)))
    nearest = np.rint(times / tick).astype(np.intp)
    ticks = np.unique(np.maximum(nearest, (times > 0.0).astype(np.intp)))
    return Lags(ticks, np.round(ticks * tick, 3))
