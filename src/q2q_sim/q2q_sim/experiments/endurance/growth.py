"""Growth of a quantity over a flight: slope of a line with its interval, and whether it is flat.

The first WARM_UP of the samples is left out. The rest is averaged in BLOCKS blocks of equally many samples,
so that samples that follow each other count once, and a line is fitted to the averages by least squares. The
interval of its slope is Student's with BLOCKS - 2 degrees of freedom. With fewer than two samples a block the
slope is not known.
"""

from dataclasses import dataclass
from math import nan

import numpy as np
from scipy.special import stdtrit

from q2q_model.signals.values import Array

WARM_UP = 0.2
"""Share of a flight in which caches fill."""
BLOCKS = 20
HOUR = 3600.0
"""[s]"""


@dataclass(frozen=True, slots=True)
class Growth:
    """Growth of one quantity of one process."""

    what: str
    unit: str
    mean: float
    per_hour: float
    """Slope, in `unit` an hour; NaN, as its interval, where it is not known."""
    low: float
    """95 % interval of the slope."""
    high: float
    allowed: float
    """Largest slope of a flat quantity, either way."""

    @property
    def verdict(self) -> str:
        """Return `flat`, `grows`, `falls`, or `undecided` where the interval is too wide or not known."""
        if -self.allowed <= self.low and self.high <= self.allowed:
            return "flat"
        if self.low > self.allowed:
            return "grows"
        return "falls" if self.high < -self.allowed else "undecided"


@dataclass(frozen=True, slots=True)
class WatchedQuantity:
    """Name, unit and limit of a quantity."""

    what: str
    unit: str
    allowed: float
    """Largest slope of a flat one, in `unit` an hour."""


def growth(kind: WatchedQuantity, t: Array, values: Array) -> Growth:
    """Return the growth of samples `values` at times `t` [s], (k,) each, k at least 1."""
    late = t >= t[0] + WARM_UP * (t[-1] - t[0])
    t, values = t[late], values[late]
    if len(t) < 2 * BLOCKS:
        return Growth(kind.what, kind.unit, float(values.mean()), nan, nan, nan, kind.allowed)
    hours, means = (
        np.array([part.mean() for part in np.array_split(one, BLOCKS)]) for one in (t / HOUR, values)
    )
    away = hours - hours.mean()
    rest = means - means.mean()  # exactly zero for a constant
    slope = float(away @ rest / (away @ away))
    rest -= slope * away
    error = float(np.sqrt(rest @ rest / (BLOCKS - 2) / (away @ away)))
    half = float(stdtrit(BLOCKS - 2, 0.975)) * error
    mean = float(values.mean())
    return Growth(kind.what, kind.unit, mean, slope, slope - half, slope + half, kind.allowed)
