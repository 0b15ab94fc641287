"""Median with an interval over models and over draws.

The interval has the percentiles of the medians of RESAMPLES bootstrap samples in two levels: models are drawn
with replacement, then draws within each (Davison, Hinkley, Bootstrap Methods and their Application, 1997,
section 3.8), always with the same random numbers.
"""

from typing import NamedTuple

import numpy as np

from q2q_model.signals.values import Array

RESAMPLES = 1000


class MedianInterval(NamedTuple):
    """Median with its 95 % interval."""

    middle: float
    low: float
    high: float


def median_interval(values: Array) -> MedianInterval:
    """Return the median and interval of `values` (models, draws); NaN where a value is not finite."""
    if values.size == 0 or not np.isfinite(values).all():
        return MedianInterval(np.nan, np.nan, np.nan)
    rng, (models, draws) = np.random.default_rng(0), values.shape
    model = rng.integers(models, size=(RESAMPLES, models, 1))
    draw = rng.integers(draws, size=(RESAMPLES, models, draws))
    medians = np.median(values[model, draw], axis=(1, 2))
    low, high = np.percentile(medians, [2.5, 97.5])
    return MedianInterval(float(np.median(values)), float(low), float(high))
