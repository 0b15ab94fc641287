"""Linear regression with Huber weights, by iterative reweighting, and an F test of its columns."""

import numpy as np
from scipy.special import fdtrc

from q2q_model.signals.values import Array

HUBER = 1.345
"""Huber threshold in standard deviations; 95 % efficient for normal errors (Huber 1981)."""
RESOLUTION = 1e-6
"""Minimum standard deviation of the residual [m/s^2]: 1e-7 g."""
ROUNDS, SETTLED = 10, 1e-4
"""Most iterations of reweighting, and the change of weights that ends them [-]."""
SIGNIFICANCE = 0.01
"""Level of the F tests of gains: the largest probability of chance that keeps extra terms [-]."""


def huber_fit(design: Array, target: Array) -> tuple[Array, Array]:
    """Return the parameters (p,) and the Huber weight of every row (m,), by iterative reweighting.

    Args:
        design: derivatives of the target with respect to the parameters, (m, p).
        target: [m/s^2], (m,).
    """
    weight = np.ones_like(target)
    scale = _scale(design)
    scaled = design / scale
    for _ in range(ROUNDS):
        value = _solve(scaled, target, weight)
        residual = np.abs(target - scaled @ value)
        threshold = HUBER * robust_deviation(residual)
        before, weight = weight, np.minimum(1.0, threshold / np.maximum(residual, 1e-12))
        if np.abs(weight - before).max() < SETTLED:
            break
    return value / scale, weight


def robust_deviation(residual: Array) -> float:
    """Return the standard deviation of residuals (m,) from their median size, for a normal [m/s^2]."""
    return max(1.4826 * float(np.median(np.abs(residual))), RESOLUTION)


def significance(whole: Array, less: Array, target: Array) -> float:
    """Return the level at which an F test finds the columns that `whole` has besides `less` significant [-].

    It compares weighted sums of squares; correlated rows count as fewer.

    Args:
        whole: design, (m, p).
        less: design without these columns, (m, < p).
        target: [m/s^2], (m,).
    """
    _, weight = huber_fit(whole, target)
    full, reduced = (_weighted_residual(design, target, weight) for design in (whole, less))
    squares = float(full @ full)
    rho = float(np.clip(full[1:] @ full[:-1] / max(squares, 1e-300), 0.0, 0.999))
    extra = whole.shape[1] - less.shape[1]
    freedom = max(weight.sum() * (1.0 - rho) / (1.0 + rho) - whole.shape[1], 1.0)
    floor = max(squares, weight.sum() * RESOLUTION**2)
    ratio = (float(reduced @ reduced) - squares) / floor * freedom / extra
    return float(fdtrc(extra, freedom, max(ratio, 0.0)))


def _weighted_residual(design: Array, target: Array, weight: Array) -> Array:
    scaled = design / _scale(design)
    return np.asarray(np.sqrt(weight) * (target - scaled @ _solve(scaled, target, weight)))


def _scale(design: Array) -> Array:
    """Return the largest magnitude in each column, above zero."""
    return np.asarray(np.maximum(np.abs(design).max(axis=0), 1e-12))


def _solve(scaled: Array, target: Array, weight: Array) -> Array:
    weighted = (weight[:, None] * scaled).T
    return np.asarray(np.linalg.lstsq(weighted @ scaled, weighted @ target, rcond=None)[0])
