"""Standard deviation of measured pushes from a jet, affine in its downwash: floor + share |eta|."""

from collections.abc import Sequence

import numpy as np
from scipy.optimize import minimize

from q2q_model.downwash.jet import Jet
from q2q_model.identification.push.along_flight import eta_on_vehicle
from q2q_model.identification.push.push_samples import PushSamples
from q2q_model.identification.statistics.intervals import Z95
from q2q_model.signals.values import Array

MOST_STD = 10.0
"""Largest std_floor [m/s^2] and relative_std [-] of a jet."""


def pushes_and_errors(jet: Jet, samples: Sequence[PushSamples]) -> tuple[Array, Array]:
    """Return |eta| and |y - eta| on exposed rows, (k,)."""
    pushes, errors = [np.empty(0)], [np.empty(0)]
    for one in samples:
        rows = np.nonzero(one.exposed)[0]
        eta = eta_on_vehicle(jet, one.motion, one.vehicle, rows)[:, 2]
        pushes.append(np.abs(eta))
        errors.append(np.abs(one.y[rows] - eta))
    return np.concatenate(pushes), np.concatenate(errors)


def affine_deviation(push: Array, error: Array) -> tuple[float, float]:
    """Return floor [m/s^2] and share [-] of the deviation floor + share |eta| of errors (m,) at |eta| (m,).

    Both are those of `deviation_of`, scaled so that 95 % of the rows lie within 1.96 deviations, because the
    tails are not normal.
    """
    if not error.any():
        return 0.0, 0.0
    floor, share = deviation_of(push, error)
    wide = float(np.quantile(error / (floor + share * push), 0.95)) / Z95
    return float(min(wide * floor, MOST_STD)), float(min(wide * share, MOST_STD))


def deviation_of(push: Array, error: Array, noise: float = 0.0) -> tuple[float, float]:
    """Return floor [m/s^2] and share, (floor + share |eta|), of maximum likelihood for a normal.

    The variance of the errors is the square of that deviation, plus that of a noise. Without any downwash the
    share is 0: nothing shows it.

    Args:
        push: |eta| [m/s^2], (k,), k at least 1.
        error: |y - eta| [m/s^2], (k,), not all 0.
        noise: its standard deviation [m/s^2].
    """

    def negative_log_likelihood(x: Array) -> float:
        std = np.hypot(np.exp(x[0]) + np.exp(x[1]) * push, noise)
        return float(np.sum(np.log(std) + 0.5 * (error / std) ** 2))

    first = np.log([max(float(np.sqrt(np.mean(error**2))), 1e-6), 0.1])
    floor, share = np.exp(minimize(negative_log_likelihood, first, method="Nelder-Mead").x)
    return float(floor), float(share) if push.any() else 0.0
