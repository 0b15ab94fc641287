"""B-splines of a jet's push, fitted with penalties (Eilers, Marx, Statistical Science 11, 1996).

    P(gap, r) = sum over a, b of B_a(gap) B_b(r) beta_ab >= 0,   P = P_r = 0 at r = REACH,  P_r = 0 at r = 0

    minimise  sum (y + T P)^2 + lambda (|D2_gap beta|^2 + |D2_r beta|^2) + mu |beta|^2   over beta >= 0

with cubic B-splines; the conditions at both ends of r tie or remove coefficients. lambda is the one with the
least squared error on blocks left out. mu is the variance of y + T P over that of beta: beta tends to zero
where nothing was flown, and a few rows outweigh it. Non-negative least squares (Lawson, Hanson 1974) acts on
the Cholesky factor of the normal matrix, so only sums over blocks are kept.
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline
from scipy.optimize import nnls

from q2q_model.identification.push.push_samples import APART, GAPS
from q2q_model.signals.values import Array
from q2q_sim.air.learning.jet.jet_coordinates import JetPlace
from q2q_sim.air.learning.statistics.block_bootstrap import BlockOfRows, block_sums

REACH = APART
"""Radius at which a jet ends [m]: nothing is measured beyond 0.15 m, and rows beyond this count as clear."""
TALLEST = GAPS[1]
"""Largest gap of the splines [m]: that of the scoring rule."""
GAP_KNOTS = np.linspace(0.0, TALLEST, 9)
RADIUS_KNOTS = np.linspace(0.0, REACH, 11)
PENALTIES = (0.3, 1.0, 3.0, 10.0, 30.0, 100.0)
"""Values of lambda to choose from [-]."""
DEFAULT_PENALTY = 3.0
RIDGE = 0.1
"""mu [-]: residuals of 0.3 m/s^2, 16 rows of which count as one (0.08 s at 100 Hz), over pushes of 3 m/s^2
give 0.16. Recorded flights left out are predicted best from 0.1 to 0.3 (docs/airs.md)."""
FOLDS = 10
DEGREE = 3


def _ends_of_radius() -> Array:
    """Return the coefficients in r by those that are free: tied on the axis, zero at REACH."""
    count = RADIUS_KNOTS.size + DEGREE - 1
    free = np.eye(count)[:, 1:-2]
    free[0, 0] = 1.0
    return free


_ALONG, _ACROSS = GAP_KNOTS.size + DEGREE - 1, _ends_of_radius()
COEFFICIENTS = _ALONG * _ACROSS.shape[1]
"""Number of free coefficients."""


def _roughness() -> Array:
    second_along = np.diff(np.eye(_ALONG), 2, axis=0)
    second_across = np.diff(np.eye(_ACROSS.shape[0]), 2, axis=0) @ _ACROSS
    parts = np.kron(second_along, np.eye(_ACROSS.shape[1])), np.kron(np.eye(_ALONG), second_across)
    return np.asarray(sum(part.T @ part for part in parts))


ROUGHNESS = _roughness()


def spline_values(gap: Array, radius: Array) -> Array:
    """Return the value of every free spline at places (k,), (k, COEFFICIENTS); zero beyond REACH."""
    if not gap.size:
        return np.zeros((0, COEFFICIENTS))
    along = _basis(gap, GAP_KNOTS)
    across = _basis(radius, RADIUS_KNOTS) @ _ACROSS
    across[radius >= REACH] = 0.0
    return np.asarray((along[:, :, None] * across[:, None, :]).reshape(gap.size, -1))


def _basis(x: Array, knots: Array) -> Array:
    full = np.concatenate([np.full(DEGREE, knots[0]), knots, np.full(DEGREE, knots[-1])])
    return np.asarray(BSpline.design_matrix(np.clip(x, knots[0], knots[-1]), full, DEGREE).toarray())


@dataclass(frozen=True, slots=True)
class Normal:
    """Normal equations of the coefficients, summed over each of B blocks."""

    square: Array
    """X' X, (B, p, p)."""
    cross: Array
    """X' y, (B, p)."""
    power: Array
    """y' y, (B,)."""


def normal_equations(place: JetPlace, y: Array, blocks: BlockOfRows) -> Normal:
    """Return the normal equations of the push y (m,) at places (m,)."""
    order = np.argsort(blocks, kind="stable")
    rows = (-place.thrust_ratio[:, None] * spline_values(place.gap, place.radius))[order]
    begins = np.flatnonzero(np.diff(blocks[order], prepend=-1))
    ends = np.append(begins[1:], order.size)
    parts = [(rows[a:b], y[order][a:b]) for a, b in zip(begins, ends, strict=True)]
    return Normal(
        square=np.stack([x.T @ x for x, _ in parts]),
        cross=np.stack([x.T @ part for x, part in parts]),
        power=block_sums(y**2, blocks),
    )


def solve_signed(normal: Normal, weight: Array, penalty: float) -> Array:
    """Return coefficients of any sign, (p,), for weights (B,): sooner solved, and as good for comparisons."""
    return np.asarray(np.linalg.solve(_square(normal, weight, penalty), weight @ normal.cross))


def penalties(penalty: float) -> Array:
    """Return the matrix of lambda (|D2_gap beta|^2 + |D2_r beta|^2) + mu |beta|^2, (p, p)."""
    return np.asarray(penalty * ROUGHNESS + RIDGE * np.eye(COEFFICIENTS))


def _square(normal: Normal, weight: Array, penalty: float) -> Array:
    return np.asarray(np.tensordot(weight, normal.square, 1) + penalties(penalty))


def solve_penalised(normal: Normal, weight: Array, penalty: float) -> Array:
    """Return the coefficients, all at least 0, for weights of the blocks (B,)."""
    lower = np.linalg.cholesky(_square(normal, weight, penalty))
    return np.asarray(nnls(lower.T, np.linalg.solve(lower, weight @ normal.cross))[0])


def squared_error(normal: Normal, weight: Array, beta: Array) -> float:
    """Return sum (y - X beta)^2 for coefficients beta (p,), over blocks of weights (B,)."""
    square = np.tensordot(weight, normal.square, 1)
    return float(weight @ normal.power - 2.0 * weight @ normal.cross @ beta + beta @ square @ beta)


def chosen_penalty(normal: Normal) -> float:
    """Return the penalty with the least squared error on blocks left out."""
    count = normal.power.size
    fold = np.arange(count) % min(FOLDS, count)
    if count < 2:
        return DEFAULT_PENALTY

    def held_out_error(penalty: float) -> float:
        out = [(fold == k).astype(np.float64) for k in range(fold.max() + 1)]
        return sum(squared_error(normal, one, solve_signed(normal, 1.0 - one, penalty)) for one in out)

    return min(PENALTIES, key=held_out_error)
