"""Say how far an estimate can be trusted, where neighbouring samples err together.

The sandwich covariance of a least-squares fit with residuals r and Jacobian J is

    B^-1 M B^-1,   B = J'J,   M = sum over blocks of (J'r)(J'r)'

times blocks / (blocks - p), which lets residuals within a block depend on each other in any way (Cameron,
Miller, A practitioner's guide to cluster-robust inference, 2015). A block is a stretch of time: errors of
flight hang together. Few blocks show too little spread, so no variance is taken below that of independent
residuals, B^-1 r'r / (m - p).
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
    samples, free = jacobian.shape
    blocks = int(row.max()) + 1
    scores = np.zeros((blocks, free))
    np.add.at(scores, row, jacobian * residual[:, None])
    bread = np.linalg.pinv(jacobian.T @ jacobian)
    together = bread @ (scores.T @ scores) @ bread * (blocks / max(blocks - free, 1))
    alone = bread * float(residual @ residual) / max(samples - free, 1)
    wider = np.sqrt(np.maximum(np.diag(alone) / np.maximum(np.diag(together), 1e-300), 1.0))
    return np.asarray(wider[:, None] * together * wider)


def intervals(value: Array, covariance: Array) -> list[Interval]:
    """Return the 95 % interval of each parameter."""
    error = Z95 * np.sqrt(np.diag(covariance))
    return [Interval(float(v), float(v - e), float(v + e)) for v, e in zip(value, error, strict=True)]
