"""Fit of the residual process (`downwash.correction.residual_process`) to residuals y - eta under wakes.

The deviation s = floor_0 + slope_0 |eta| is of maximum likelihood for residuals of variance s^2 + noise^2.
The normalised residual z = r / s has the autocovariance c exp(-h / T). c and T are a least-squares fit over
the lags h of whole ticks nearest to `LAGS`, never 0, where the noise is, weighted by their pairs, and

    floor = sqrt(c) floor_0,   slope = sqrt(c) slope_0,   noise^2 = mean (r^2 - c s^2)

Both are fitted three times: first without noise, then with that of the fit before, where c is nearly 1. Where
the noise is as large as the process, floor and slope of the second fit are up to 20 % from where further fits
end, those of the third 3 %. Noise in the deviation would add to floor and take from slope.

Intervals are those of a jackknife over vehicles of flights, or over pieces if there are fewer than three,
with the quantile of Student's t of one degree of freedom less than there are parts. A value at its bound, as
a slope of 0 (also where the model has no downwash) or an uncorrelated residual, has none: it stays there
whatever part is left out.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.optimize import curve_fit
from scipy.special import stdtrit

from q2q_model.downwash.correction.residual_process import ResidualProcess
from q2q_model.downwash.interaction_model import InteractionModel
from q2q_model.identification.jet.jet_deviation import deviation_of
from q2q_model.identification.push.along_flight import eta_on_vehicle
from q2q_model.identification.push.push_samples import PushSamples
from q2q_model.identification.statistics.intervals import LEVEL, Interval
from q2q_model.signals.values import Array

LAGS = np.arange(0.02, 0.16, 0.01)
"""Wanted lags [s]: from the first that filters of the measurement do not correlate to twice the correlation
time."""
FEWEST_ROWS = 500
"""Fewest exposed rows: 5 s at 100 Hz."""
FEWEST_LAGS = 3
"""Fewest lags: one more than unknowns."""
FEWEST_PARTS = 3
"""Fewest parts of a jackknife."""
LEAST_NOISE = 1e-3
"""[m/s^2]"""
NEGLIGIBLE = 1e-6
"""Floor [m/s^2] and slope [-] below which the search for their logarithm has gone to minus infinity."""
FIRST, LOW, HIGH = (0.8, 0.08), (0.0, 0.01), (1.0, 5.0)
"""Share of z^2 that is correlated and time T [s] to begin with, and their bounds."""
NAMES = ("floor", "slope", "time_s", "noise")


@dataclass(frozen=True, slots=True)
class ResidualFit:
    """Fitted process with the interval of each value."""

    process: ResidualProcess
    intervals: tuple[tuple[str, Interval | None], ...]
    """None for a value at its bound."""


@dataclass(frozen=True, slots=True)
class _Part:
    """Exposed rows of one vehicle of one flight, or of a stretch of it."""

    tick: Array
    """Number of the tick, (k,)."""
    period: float
    """[s]"""
    push: Array
    """|eta| [m/s^2], (k,)."""
    residual: Array
    """[m/s^2], (k,)."""


class _LagSums(NamedTuple):
    """Pairs of rows one lag apart, (L,) each."""

    times: Array
    """Lag [s], in whole milliseconds: parts of one rate share their lags."""
    products: Array
    """Sum of z z' [-]."""
    pairs: Array
    """Number of pairs [-]."""


def fit_residual(model: InteractionModel, samples: Sequence[PushSamples]) -> ResidualFit | None:
    """Return the process fitted to exposed rows.

    None for fewer than `FEWEST_ROWS`, for fewer than `FEWEST_LAGS`, as below 16 Hz, without correlation, or
    if every residual is 0.
    """
    parts = [_part(model, one) for one in samples if one.exposed.any()]
    if len(parts) < FEWEST_PARTS:
        parts = [piece for part in parts for piece in _pieces(part)]
    if sum(part.push.size for part in parts) < FEWEST_ROWS or (whole := _process(parts)) is None:
        return None
    left = [_process(parts[:k] + parts[k + 1 :]) for k in range(len(parts))]
    values = np.array([_values(one) for one in left if one is not None])
    if len(values) < 2:
        return None
    spread = np.sqrt((len(values) - 1.0) * values.var(axis=0))
    wide = stdtrit(len(values) - 1.0, 0.5 + 0.5 * LEVEL) * spread
    spans = [
        None if bound else Interval(value, max(value - half, 0.0), value + half)
        for value, half, bound in zip(_values(whole), wide.tolist(), _at_bounds(whole), strict=True)
    ]
    return ResidualFit(whole, tuple(zip(NAMES, spans, strict=True)))


def _part(model: InteractionModel, one: PushSamples) -> _Part:
    rows, period = np.flatnonzero(one.exposed), float(np.median(np.diff(one.motion.t)))
    eta = eta_on_vehicle(model, one.motion, one.vehicle, rows)[:, 2]
    tick = np.rint(one.motion.t[rows] / period)
    return _Part(tick, period, np.abs(eta), one.y[rows] - eta)


def _pieces(part: _Part) -> list[_Part]:
    """Return the rows of a part in pieces of FEWEST_ROWS / 2 rows."""
    cuts = range(FEWEST_ROWS // 2, part.push.size, FEWEST_ROWS // 2)
    columns = (np.split(values, list(cuts)) for values in (part.tick, part.push, part.residual))
    return [_Part(t, part.period, push, residual) for t, push, residual in zip(*columns, strict=True)]


def _process(parts: Sequence[_Part]) -> ResidualProcess | None:
    first = _process_beside(parts, 0.0)
    second = None if first is None else _process_beside(parts, first.noise)
    return None if second is None else _process_beside(parts, second.noise)


def _process_beside(parts: Sequence[_Part], noise: float) -> ResidualProcess | None:
    """Return the process whose deviation is that of the residuals apart from a noise [m/s^2]."""
    push = np.concatenate([part.push for part in parts])
    residual = np.concatenate([part.residual for part in parts])
    if not residual.any():
        return None
    floor, slope = deviation_of(push, np.abs(residual), noise)
    lags = _lag_sums(parts, floor, slope)
    size = float(np.mean((residual / (floor + slope * push)) ** 2))
    if lags.times.size < FEWEST_LAGS:
        return None
    correlation, scatter = lags.products / lags.pairs / size, 1.0 / np.sqrt(lags.pairs)
    try:
        (share, time), _ = curve_fit(_decaying, lags.times, correlation, FIRST, scatter, bounds=(LOW, HIGH))
    except RuntimeError:  # no convergence
        return None
    wide = float(np.sqrt(share * size))
    rest = float(np.mean(residual**2 - (wide * (floor + slope * push)) ** 2))
    return ResidualProcess(wide * floor, wide * slope, float(time), math.sqrt(max(rest, LEAST_NOISE**2)))


def _decaying(lag: Array, share: float, time: float) -> Array:
    return np.asarray(share * np.exp(-lag / time))


def _lag_sums(parts: Sequence[_Part], floor: float, slope: float) -> _LagSums:
    """Return the sums over all parts at the lags of which any part has pairs."""
    found = [_products(part, floor, slope) for part in parts]
    times, where = np.unique(np.concatenate([one.times for one in found]), return_inverse=True)
    products, pairs = np.zeros(times.size), np.zeros(times.size)
    np.add.at(products, where, np.concatenate([one.products for one in found]))
    np.add.at(pairs, where, np.concatenate([one.pairs for one in found]))
    return _LagSums(times[pairs > 0], products[pairs > 0], pairs[pairs > 0])


def _products(part: _Part, floor: float, slope: float) -> _LagSums:
    """Return the sums of a part at its lags of at least one tick."""
    z = part.residual / (floor + slope * part.push)
    ticks = np.unique(np.maximum(np.rint(LAGS / part.period), 1.0))
    found = _LagSums(np.round(ticks * part.period, 3), np.zeros(ticks.size), np.zeros(ticks.size))
    for k, lag in enumerate(ticks):
        later = np.searchsorted(part.tick, part.tick + lag).clip(0, part.tick.size - 1)
        pair = part.tick[later] == part.tick + lag
        found.products[k], found.pairs[k] = (z * z[later])[pair].sum(), pair.sum()
    return found


def _values(process: ResidualProcess) -> list[float]:
    return [process.floor, process.slope, process.time_s, process.noise]


def _at_bounds(process: ResidualProcess) -> list[bool]:
    """Return whether each value is at a bound of its search."""
    return [
        process.floor < NEGLIGIBLE,
        process.slope < NEGLIGIBLE,
        not 1.001 * LOW[1] < process.time_s < 0.999 * HIGH[1],
        process.noise <= LEAST_NOISE,
    ]
