"""Intervals of what differs between flights of vehicles, each of them one independent draw.

    mean                m +- t s / sqrt(n)
    deviation           sqrt(max(s^2 (n - 1) / x - e, 0))          x: quantiles of chi-square with n - 1
    median              v +- t s_m sqrt(n / (n - 1))
    any other estimate  v +- t s_b sqrt(n / (n - 1))

The first two hold for normal draws. In simulations the third holds the median of 3 to 38 normal, lognormal or
uniform draws in 94 to 98 %. One vehicle in several flights counts as several: where these are alike,
intervals are too narrow.

| symbol | meaning |
|---|---|
| n | draws; fewer than FEWEST give no interval |
| m, s | mean and standard deviation of the draws |
| e | mean square of the draws' own errors, which is not part of the deviation |
| v, s_b | estimate, and its standard deviation over bootstrap draws |
| s_m | the same of a median, exactly: over all draws (Maritz and Jarrett, JASA 73, 1978) |
| t | Student's t with n - 1 degrees of freedom |
"""

import numpy as np
from scipy.special import betainc, chdtri, stdtrit

from q2q_model.identification.statistics.intervals import LEVEL
from q2q_model.signals.values import Array
from q2q_sim.air.learning.statistics.block_bootstrap import (
    FEWEST,
    Spread,
    WeightedEstimate,
    bootstrap_draws,
)

UPPER = 0.5 + 0.5 * LEVEL


def mean_spread(draws: Array) -> Spread:
    """Return the mean of draws (n,) with its interval, (1,)."""
    wide = draws.std(ddof=1) / np.sqrt(draws.size) if draws.size >= FEWEST else np.nan
    return _around(np.array([draws.mean()]), np.array([wide]), draws.size)


def deviation_of_draws(draws: Array, own: float = 0.0) -> Spread:
    """Return the standard deviation between draws (n,) beyond own errors e, and its interval, (1,)."""
    return deviation_spread(float(((draws - draws.mean()) ** 2).sum()), draws.size - 1, own)


def deviation_spread(squares: float, freedom: int, own: float = 0.0) -> Spread:
    """Return a standard deviation, beyond own errors e, with its interval, (1,).

    Args:
        squares: sum of squared differences.
        freedom: their degrees of freedom; below FEWEST - 1 there is no interval, at 0 the value is 0.
        own: e, in the unit of `squares`.
    """
    quantiles = chdtri(freedom, (1.0 - UPPER, UPPER)) if freedom >= FEWEST - 1 else np.full(2, np.nan)
    low, high = np.sqrt(np.maximum(squares / quantiles - own, 0.0))
    value = np.sqrt(max(squares / max(freedom, 1) - own, 0.0))
    return Spread(np.array([value]), np.array([low]), np.array([high]))


def median_spread(each: Array, least: float = -np.inf) -> Spread:
    """Return the median of draws (n, p) with its interval, (p,), of `least` or more."""
    count = len(each)
    middle = 0.5 * (count + 1)
    weight = np.diff(betainc(middle, middle, np.linspace(0.0, 1.0, count + 1)))
    ranked = np.sort(each, axis=0)
    error = np.sqrt(np.maximum(weight @ ranked**2 - (weight @ ranked) ** 2, 0.0))
    known = np.sqrt(count / (count - 1.0)) if count >= FEWEST else np.nan
    return _around(np.median(each, axis=0), known * error, count, least)


def spread_of_vehicles(estimate: WeightedEstimate, count: int, least: float = -np.inf) -> Spread:
    """Return an estimate from `count` draws with its interval, (p,), whose ends are `least` or more."""
    value = estimate(np.ones(count))
    if count < FEWEST:
        return _around(value, np.full_like(value, np.nan), count)
    deviation = np.std(bootstrap_draws(estimate, count), axis=0, ddof=1)
    return _around(value, deviation * np.sqrt(count / (count - 1.0)), count, least)


def _around(value: Array, error: Array, count: int, least: float = -np.inf) -> Spread:
    wide = stdtrit(max(count - 1, 1), UPPER) * error
    return Spread(*(np.maximum(one, least) for one in (value, value - wide, value + wide)))
