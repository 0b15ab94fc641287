"""Power law of a cost over a size, with one bend where the measurements have one.

Least squares in logarithms, x = log(n / n_0):

    straight    log t = a + b x
    bent        log t = a + b_1 min(x, 0) + b_2 max(x, 0)

n_0 is the measured size with the least sum of squares; at least three sizes lie on each side, itself counted
on both. The bend is kept if an F test over its two parameters finds it significant. Intervals are those of
Student's t with the deviation of the residuals; they assume that n_0 is known.

| symbol | name | meaning [unit] |
|---|---|---|
| n | sizes | number of vehicles |
| t | costs | time [s] or memory [byte] |
| a | level | logarithm of the cost at n_0 (straight: at the first size) |
| b b_1 b_2 | below, above | slopes: exponents of the power law |
| n_0 | bend | size at which the slope changes |
"""

from dataclasses import dataclass

import numpy as np
from scipy.stats import f, t

from q2q_model.signals.values import Array

SIDE = 3
"""Fewest sizes on each side of a bend: two make a slope, the third a residual."""
SIGNIFICANT = 0.05
"""Level of the F test [-]."""
ROUNDING = 1e-20
"""Sum of squares that is rounding of logarithms [-]."""


@dataclass(frozen=True, slots=True)
class Slope:
    """Exponent of a power law with its 95 % interval."""

    value: float
    low: float
    high: float


@dataclass(frozen=True, slots=True)
class PowerLaw:
    """Power law, straight or bent, with the uncertainty of its fit."""

    origin: float
    """Size at which the first coefficient holds: the bend, or the first size."""
    coefficients: Array
    """a, b of a straight law, a, b_1, b_2 of a bent one, (p,)."""
    covariance: Array
    """Of the coefficients, (p, p)."""
    freedom: int
    """Degrees of freedom of the residuals."""
    left: float
    """Sum of squares of the residuals."""

    @property
    def bent(self) -> bool:
        """Return whether the law has a bend."""
        return len(self.coefficients) > 2

    @property
    def below(self) -> Slope:
        """Return the slope below the bend, or everywhere."""
        return self._slope(1)

    @property
    def above(self) -> Slope:
        """Return the slope above the bend, or everywhere."""
        return self._slope(-1)

    def cost(self, sizes: Array) -> Array:
        """Return the cost of sizes (k,), (k,)."""
        return np.asarray(np.exp(_columns(sizes, self.origin, bent=self.bent) @ self.coefficients))

    def cost_interval(self, size: float) -> tuple[float, float]:
        """Return the 95 % interval of the law's cost at a size."""
        (row,) = _columns(np.array([size]), self.origin, bent=self.bent)
        half = self._quantile * float(np.sqrt(row @ self.covariance @ row))
        middle = float(row @ self.coefficients)
        return float(np.exp(middle - half)), float(np.exp(middle + half))

    @property
    def _quantile(self) -> float:
        return float(t.ppf(0.975, self.freedom))

    def _slope(self, column: int) -> Slope:
        value = float(self.coefficients[column])
        half = self._quantile * float(np.sqrt(self.covariance[column, column]))
        return Slope(value, value - half, value + half)


def power_law(sizes: Array, costs: Array) -> PowerLaw:
    """Return the law of costs (k,) at rising sizes (k,); raise ValueError for fewer than three."""
    if len(sizes) < SIDE:
        raise ValueError(f"{len(sizes)} sizes: a slope with an interval needs {SIDE} or more")
    straight = _fit(sizes, costs, sizes[0], bent=False)
    bends = sizes[SIDE - 1 : len(sizes) - SIDE + 1] if len(sizes) >= 2 * SIDE else sizes[:0]
    laws = [_fit(sizes, costs, bend, bent=True) for bend in bends]
    best = min(laws, key=lambda law: law.left, default=straight)
    return best if _is_better(best, straight) else straight


def _columns(sizes: Array, origin: float, *, bent: bool) -> Array:
    """Return the factors of the coefficients, (k, p)."""
    x = np.log(sizes / origin)
    slopes = [np.minimum(x, 0.0), np.maximum(x, 0.0)] if bent else [x]
    return np.column_stack([np.ones_like(x), *slopes])


def _fit(sizes: Array, costs: Array, origin: float, *, bent: bool) -> PowerLaw:
    columns, y = _columns(sizes, origin, bent=bent), np.log(costs)
    coefficients, *_ = np.linalg.lstsq(columns, y, rcond=None)
    left, freedom = float(((y - columns @ coefficients) ** 2).sum()), len(y) - columns.shape[1]
    covariance = np.linalg.inv(columns.T @ columns) * left / freedom
    return PowerLaw(float(origin), coefficients, covariance, freedom, left)


def _is_better(bent: PowerLaw, straight: PowerLaw) -> bool:
    """Return whether a bend explains more than chance would; its place costs a degree of freedom too."""
    freedom = bent.freedom - 1
    if freedom < 1 or straight.left < ROUNDING:
        return False
    gained = (straight.left - bent.left) / 2
    return gained > float(f.isf(SIGNIFICANT, 2, freedom)) * bent.left / freedom
