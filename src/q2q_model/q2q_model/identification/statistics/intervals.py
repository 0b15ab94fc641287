"""Confidence intervals of M-estimates with residuals correlated in clusters.

An estimate that minimises sum rho(r_i) with psi = rho' solves sum psi_i J_i = 0. With

    B_g = sum psi'_i J_i J_i',  s_g = sum psi_i J_i  over cluster g,   B = sum of B_g

the sandwich covariance of the estimate is, with B = L L',

    V = sum over g of d_g d_g',   d_g = L'^-1 (I - C_g)^-1/2 L^-1 s_g,   C_g = L^-1 B_g L'^-1

where the root corrects each cluster's score for its own leverage: V is unbiased for homoscedastic residuals
and psi' = 1 (CR2: Bell, McCaffrey, Bias reduction in standard errors for linear regression with multi-stage
samples, 2002). Intervals take Student's t with

    nu = (sum a_g)^2 / sum a_g^2 - 1,   a_g = share of cluster g in the variance for homoscedastic residuals

degrees of freedom (Satterthwaite 1946): fewer if clusters are few or one has most of the information.
Clusters are flights if there are at least `MANY`, else stretches of time `LONG` times the residuals'
correlation time (Cameron, Miller, A practitioner's guide to cluster-robust inference, 2015).

Clusters allow for residuals that are correlated in time, not for those that are correlated with their own
rows J_i, as where residuals are fed back: the estimate is biased then, and its interval is around a wrong
value.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from q2q_model.signals.values import Array

LEVEL = 0.95
"""Confidence level [-]."""
Z95 = 1.96
"""Standard deviations on either side of the mean that contain LEVEL of a normal."""
MANY = 12
"""Fewest flights that serve as clusters: t with 11 degrees of freedom is 12 % wider than a normal."""
LONG = 10.0
"""Length of a cluster over the correlation time [-]: a tenth of it correlates across its ends."""
RIDGE = 1e-12
"""Minimum share of the information in other clusters [-]; below it the interval is unbounded."""
UNKNOWN = 1e9
"""Half width of an unbounded interval, in units of the parameter."""


@dataclass(frozen=True, slots=True)
class Interval:
    """Estimate with its 95 % interval."""

    value: float
    low: float
    high: float

    @property
    def is_positive(self) -> bool:
        """Return whether the interval excludes zero; otherwise a gain is not identified."""
        return self.low > 0.0

    def as_list(self) -> list[float]:
        """Return [value, low, high], as in the JSON of `identify`."""
        return [self.value, self.low, self.high]


@dataclass(frozen=True, slots=True)
class EstimatingRows:
    """Estimating equations of an M-estimate at its solution, one row per residual."""

    jacobian: Array
    """Derivative of the residual with respect to the parameters, (m, p)."""
    psi: Array
    """Derivative of the loss with respect to the residual, (m,); the residual for least squares."""
    slope: Array
    """psi', (m,); ones for least squares."""
    cluster: Array
    """Cluster number of each row, (m,)."""


@dataclass(frozen=True, slots=True)
class Stretch:
    """Residuals of one vehicle of one flight, in order of time."""

    flight: int
    t: Array
    """[s], ascending, (k,); may have gaps."""
    residual: Array


def least_squares_rows(jacobian: Array, residual: Array, cluster: Array) -> EstimatingRows:
    """Return the rows of an unweighted least-squares fit: jacobian (m, p), residual (m,), cluster (m,)."""
    return EstimatingRows(jacobian, residual, np.ones_like(residual), cluster)


def cluster_rows(stretches: Sequence[Stretch], shortest: float) -> Array:
    """Return the cluster of every row, (m,), in the order of the stretches.

    Args:
        stretches: all residuals of a fit.
        shortest: least length of a cluster [s] if flights are too few to be clusters.
    """
    if len({one.flight for one in stretches}) >= MANY:
        return np.concatenate([np.full(one.t.size, float(one.flight)) for one in stretches])
    length = max(shortest, LONG * correlation_time(stretches))
    return np.concatenate([1e6 * k + _pieces(one.t, length) for k, one in enumerate(stretches) if one.t.size])


def _pieces(t: Array, length: float) -> Array:
    """Return the number of each row's piece, (k,): runs between gaps, cut evenly into pieces of `length`."""
    begins = np.flatnonzero(np.diff(t, prepend=-np.inf) > length / 2.0)
    run = np.zeros(t.size, dtype=np.intp)
    run[begins] = 1
    run = np.cumsum(run) - 1
    first, last = t[begins], t[np.append(begins[1:], t.size) - 1]
    pieces = np.maximum(np.floor((last - first) / length), 1.0)
    share = (t - first[run]) / np.maximum(last - first, np.finfo(float).tiny)[run]
    return np.asarray(
        (np.cumsum(pieces) - pieces)[run] + np.minimum(np.floor(share * pieces[run]), pieces[run] - 1.0)
    )


def correlation_time(stretches: Sequence[Stretch]) -> float:
    """Return the correlation time of residuals [s], the integral of their autocorrelation.

    The integral ends where the correlation falls below a tenth, or after a quarter of the longest stretch.
    """
    dt = min((float(np.median(np.diff(one.t))) for one in stretches if one.t.size > 1), default=0.0)
    if dt <= 0.0:
        return 0.0
    grids = [_on_grid(one, dt) for one in stretches if one.t.size]
    square = sum(float(grid @ grid) for grid, _ in grids) / sum(float(present.sum()) for _, present in grids)
    total, longest = 0.5 * dt, max(grid.size for grid, _ in grids) // 4
    for lag in range(1, longest):
        pairs = sum(float(present[lag:] @ present[:-lag]) for _, present in grids)
        along = sum(float(grid[lag:] @ grid[:-lag]) for grid, _ in grids)
        if along <= 0.1 * square * pairs:  # also with zero residuals, or no pair at this lag
            break
        total += dt * along / pairs / square
    return total


def intervals(
    value: Array, rows: EstimatingRows, bounds: tuple[Array, Array] | None = None
) -> list[Interval]:
    """Return the 95 % interval of each parameter, clipped to bounds (low, high), (p,)."""
    return around(
        value, half_widths(rows), bounds or (np.full_like(value, -np.inf), np.full_like(value, np.inf))
    )


def around(value: Array, error: Array, bounds: tuple[Array, Array]) -> list[Interval]:
    """Return intervals by their half widths, clipped to bounds (low, high), (p,)."""
    low, high = bounds
    ends = np.clip([value - error, value + error], low, high)
    return [Interval(float(v), float(a), float(b)) for v, a, b in zip(value, *ends, strict=True)]


def half_widths(rows: EstimatingRows) -> Array:
    """Return the half width of each parameter's interval, (p,)."""
    variance, freedom = variances(rows)
    wide = np.sqrt(variance) * stdtrit(freedom, 0.5 + 0.5 * LEVEL)
    return np.asarray(np.where(np.isfinite(wide), np.minimum(wide, UNKNOWN), UNKNOWN))


def variances(rows: EstimatingRows) -> tuple[Array, Array]:
    """Return each parameter's variance and its degrees of freedom, (p,); infinite without information."""
    scale = np.sqrt((rows.slope[:, None] * rows.jacobian**2).sum(axis=0))
    known = scale > 0.0
    variance, freedom = np.full(scale.size, np.inf), np.ones(scale.size)
    bread, alike, score = _sums(rows, rows.jacobian[:, known] / scale[known])
    eye = np.eye(int(known.sum()))
    root = np.linalg.inv(np.linalg.cholesky(bread.sum(axis=0) + RIDGE * eye))  # L^-1
    share, axes = np.linalg.eigh(root @ bread @ root.T)  # of C_g: (G, p), (G, p, p)
    free = axes / np.sqrt(np.maximum(1.0 - share, RIDGE))[:, None] @ np.swapaxes(axes, 1, 2)
    moved = root.T @ free @ root  # effect of a unit score of cluster g on the estimate, (G, p, p)
    caused = np.einsum("gab,gbc,gac->ga", moved, alike, moved)  # diagonal of moved alike moved'
    step = (moved @ score[..., None])[..., 0]
    variance[known] = (step**2).sum(axis=0) / scale[known] ** 2
    fewer = caused.sum(axis=0) ** 2 / np.maximum((caused**2).sum(axis=0), np.finfo(float).tiny)
    freedom[known] = np.maximum(fewer - 1.0, 1.0)
    return variance, freedom


def _sums(rows: EstimatingRows, jacobian: Array) -> tuple[Array, Array, Array]:
    """Return sums over clusters of psi' J J', J J' (G, p, p) and psi J (G, p)."""
    order = np.argsort(rows.cluster, kind="stable")
    jacobian, slope, psi = jacobian[order], rows.slope[order], rows.psi[order]
    begins = np.flatnonzero(np.diff(rows.cluster[order], prepend=np.nan))
    squares = jacobian[:, :, None] * jacobian[:, None, :]  # (m, p, p)
    bread = np.add.reduceat(slope[:, None, None] * squares, begins, axis=0)
    return bread, np.add.reduceat(squares, begins, axis=0), np.add.reduceat(psi[:, None] * jacobian, begins)


def _on_grid(one: Stretch, dt: float) -> tuple[Array, Array]:
    """Return residuals on a grid of step dt, zero where missing, and whether each exists, (T,)."""
    tick = np.round((one.t - one.t[0]) / dt).astype(np.intp)
    grid, present = np.zeros((2, int(tick[-1]) + 1))
    grid[tick], present[tick] = one.residual, 1.0
    return grid, present
