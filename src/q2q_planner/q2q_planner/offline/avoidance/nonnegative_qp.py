"""Interior point solver of min 1/2 x'Gx - b'x over x >= 0, G positive definite: the dual of a least-norm QP.

Mehrotra's predictor-corrector interior point method (Mehrotra, On the implementation of a primal-dual
interior point method, 1992). Optimality is s = Gx - b >= 0, x >= 0, x s = 0; each step solves
(G + diag(s / x)) dx = ..., one Cholesky factor for both directions.
"""

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from q2q_model.signals.values import Array

GAP = 1e-10
"""Relative complementarity at convergence."""
MOST_STEPS = 60
"""Most steps; 10 to 25 are usual."""
BACK_OFF = 0.995
"""Largest step, as a share of the distance to the boundary."""


def solve_nonnegative_qp(G: Array, b: Array) -> Array:
    """Return x (m,) of least 1/2 x'Gx - b'x over x >= 0, for G (m, m) and b (m,)."""
    if not (b > 0.0).any():
        return np.zeros_like(b)
    scale = 1.0 / np.sqrt(np.diagonal(G))  # unit diagonal
    return np.asarray(scale * _interior_point(G * scale * scale[:, None], b * scale))


def _interior_point(G: Array, b: Array) -> Array:
    size = float(np.abs(b).max())
    x = np.full_like(b, size)
    s = np.maximum(G @ x - b, size)
    for _ in range(MOST_STEPS):
        rest, gap = G @ x - b - s, float(x @ s) / len(b)
        if gap < GAP * size * size and np.abs(rest).max() < GAP * size:
            break
        factor = cho_factor(G + np.diag(s / x), check_finite=False)
        dx, ds = _direction(factor, (x, s, rest), -x * s)
        best = float(((x + _step(x, dx) * dx) @ (s + _step(s, ds) * ds)) / len(b))
        centre = gap * (best / gap) ** 3
        dx, ds = _direction(factor, (x, s, rest), centre - x * s - dx * ds)
        length = BACK_OFF * min(_step(x, dx), _step(s, ds))
        x, s = x + length * dx, s + length * ds
    return x


def _direction(
    factor: tuple[Array, bool], point: tuple[Array, Array, Array], target: Array
) -> tuple[Array, Array]:
    """Return (dx, ds) with G dx - ds = -rest and s dx + x ds = target."""
    x, s, rest = point
    dx = cho_solve(factor, target / x - rest, check_finite=False)
    return dx, (target - s * dx) / x


def _step(value: Array, change: Array) -> float:
    """Return the longest step up to 1 that keeps value + step change above zero."""
    falling = change < 0.0
    return min(1.0, float((-value[falling] / change[falling]).min(initial=1.0)))
