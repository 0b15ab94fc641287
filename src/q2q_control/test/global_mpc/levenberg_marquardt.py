"""Levenberg-Marquardt method: least squares of residuals, by damped Gauss-Newton steps.

    (J' J + mu D) step = -J' residual,  mu down after a success, up after a failure;  D: the diagonal of J' J

More, The Levenberg-Marquardt algorithm, Lecture Notes in Mathematics 630, 1978.
"""

from typing import Protocol

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from q2q_model.signals.values import Array

FIRST_DAMPING, MOST_DAMPING = 1e-2, 1e8
"""mu at the start, and where no step is found any more."""


class LeastSquares(Protocol):
    """Residuals of some weights, and their derivatives."""

    def residual(self, weights: Array) -> Array:
        """Return all residuals, (m,)."""

    def jacobian(self, weights: Array) -> Array:
        """Return d residual / d weights, (m, weights)."""


def minimise(fit: LeastSquares, weights: Array, iterations: int, tolerance: float) -> Array:
    """Return weights of least squares, from given ones.

    It ends after `iterations`, or when one decreases the sum of squares by less than the share `tolerance`.
    """
    residual = fit.residual(weights)
    damping, loss = FIRST_DAMPING, float(residual @ residual)
    for _ in range(iterations):
        jacobian = fit.jacobian(weights)
        normal, right = jacobian.T @ jacobian, jacobian.T @ residual
        before = loss
        while damping < MOST_DAMPING:
            scale = damping * (np.diag(normal) + 1e-9)
            trial = weights - cho_solve(cho_factor(normal + np.diag(scale)), right)
            trial_residual = fit.residual(trial)
            trial_loss = float(trial_residual @ trial_residual)
            if trial_loss < loss:
                weights, residual, loss, damping = trial, trial_residual, trial_loss, damping / 5.0
                break
            damping *= 4.0
        if before - loss <= tolerance * before:
            break
    return weights
