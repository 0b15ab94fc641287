"""Say how far an estimate can be trusted, where neighbouring samples err together.

The sandwich covariance of a least-squares fit with residuals r and Jacobian J is

    B^-1 M B^-1,   B = J'J,   M = sum over blocks of (J'r)(J'r)'

which lets residuals within a block depend on each other in any way (Cameron, Miller, A practitioner's guide
to cluster-robust inference, 2015). A block is a stretch of time: errors of flight hang together.
"""

from dataclasses import dataclass

import numpy as np

from q2q_model.signals import Array

Z95 = 1.96
"""Half width of a 95 % interval in standard deviations."""


@dataclass(frozen=True, slots=True)
class Interval:
    """Hold an estimate with its 95 % interval."""

    value: float
    low: float
    high: float

    def as_list(self) -> list[float]:
        """Return [value, low, high], as the JSON of `identify` has it."""
        return [self.value, self.low, self.high]


def sandwich(jacobian: Array, residual: Array, block: Array) -> Array:
    """Return the covariance of the parameters, (p, p), for jacobian (m, p), residual (m,), block (m,)."""
    _, row = np.unique(block, return_inverse=True)
    scores = np.zeros((row.max() + 1, jacobian.shape[1]))
    np.add.at(scores, row, jacobian * residual[:, None])
    bread = np.linalg.pinv(jacobian.T @ jacobian)
    return np.asarray(bread @ (scores.T @ scores) @ bread)


def intervals(value: Array, covariance: Array) -> list[Interval]:
    """Return the 95 % interval of each parameter."""
    error = Z95 * np.sqrt(np.diag(covariance))
    return [Interval(float(v), float(v - e), float(v + e)) for v, e in zip(value, error, strict=True)]
