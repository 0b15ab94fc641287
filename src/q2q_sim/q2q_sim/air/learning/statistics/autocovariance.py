"""Autocovariance of rows that are not all known or not all there: products of two rows a lag apart."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from q2q_model.signals.values import Array, Mask, Rows


class Products(NamedTuple):
    """Pairs of known rows one lag apart."""

    first: Rows
    """Index of the earlier row, (m,)."""
    second: Rows


class Lags(NamedTuple):
    """Lags of a flight, none of which is there twice."""

    ticks: NDArray[np.intp]
    """(L,), ascending."""
    times: Array
    """The same [s], in whole milliseconds: flights of one rate share their lags, (L,)."""
    tick: NDArray[np.intp]
    """Tick of each row of the flight: a lost row leaves out its tick, (T,)."""


def lagged_pairs(known: Mask, lags: Lags) -> Iterator[Products]:
    """Yield the pairs of known rows (T,) at each lag."""
    rows = np.flatnonzero(known)
    tick = lags.tick[rows]
    for lag in lags.ticks:
        later = np.searchsorted(tick, tick + lag).clip(max=rows.size - 1)
        pair = tick[later] == tick + lag
        yield Products(rows[pair], rows[later[pair]])


def autocovariance(values: Array, known: Mask, lags: Lags) -> Array:
    """Return the mean product of known values at each lag, (L,); 0 without pairs."""
    found = np.zeros(lags.ticks.size)
    for k, (first, second) in enumerate(lagged_pairs(known, lags)):
        if first.size:
            found[k] = float(np.mean(values[first] * values[second]))
    return found


def flight_lags(t: Array, times: Array) -> Lags:
    """Return the lags of a flight with stamps t [s] that are nearest to `times` [s], (K,).

    A slow flight has fewer than K, at other times. Only a lag of 0 is shorter than a tick.
    """
    period = float(np.median(np.diff(t)))
    nearest = np.rint(times / period).astype(np.intp)
    ticks = np.unique(np.maximum(nearest, (times > 0.0).astype(np.intp)))
    return Lags(ticks, np.round(ticks * period, 3), np.rint((t - t[0]) / period).astype(np.intp))
