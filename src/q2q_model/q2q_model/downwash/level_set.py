"""Zone in which a learned downwash exceeds a threshold, as a table of signed distances.

    L = { dr : |eta(dr)| >= threshold or |eta(-dr)| >= threshold }

A law at rest depends on dxy and dz alone, so L is a region of that half plane. Its boundary points are the
crossings of |eta| with the threshold on the edges of a grid. A table holds the distance from every grid point
to the nearest crossing, and queries interpolate in it. Beyond the table the result is a lower bound,
hypot(distance to the table, distance at its edge), because L lies inside the table, which is convex.

Crossings are at most a grid step apart, so distances are accurate to half a step. Where a law
still exceeds the threshold at the end of its reach, the set ends up to two steps beyond, and never before.
"""

from dataclasses import dataclass

import numpy as np

from q2q_model.downwash.interaction_model import InteractionModel, downwash_at_rest
from q2q_model.signals.values import Array

STEP = 0.01
"""Grid step [m]."""

LAST = STEP * (1.0 - 1e-6)
"""The first grid point at or beyond the reach is nearer to it than this [m]: a step, less rounding."""

MARGIN = 0.5
"""Extent of the table beyond the law's reach [m]: the distance that planners query."""


@dataclass(frozen=True, slots=True, eq=False)
class LevelSet:
    """Level set of a downwash model as a table; a Zone made by `level_set`."""

    threshold: float
    """|eta| on the boundary [m/s^2]."""
    table: Array
    """Signed distance [m] at (dxy, |dz|) = (row, column) * STEP, (rows, columns)."""

    @property
    def eps(self) -> float:
        """Return the largest horizontal distance inside [m]."""
        return float(STEP * (np.nonzero((self.table < 0.0).any(axis=1))[0].max() + 1))

    @property
    def d(self) -> float:
        """Return the largest height difference inside [m]."""
        return float(STEP * (np.nonzero((self.table < 0.0).any(axis=0))[0].max() + 1))

    def signed_distance(self, rel_pos: Array) -> Array:
        """Return the distance to the boundary [m], (...,), negative inside."""
        where = np.stack([np.hypot(rel_pos[..., 0], rel_pos[..., 1]), np.abs(rel_pos[..., 2])], axis=-1)
        edge = STEP * (np.array(self.table.shape) - 1)
        clamped = np.minimum(where, edge)
        beyond = np.hypot(where[..., 0] - clamped[..., 0], where[..., 1] - clamped[..., 1])
        near = self._interpolate(clamped / STEP)
        return np.asarray(np.where(beyond > 0.0, np.hypot(beyond, near), near))

    def _interpolate(self, at: Array) -> Array:
        corner = np.minimum(at.astype(np.intp), np.array(self.table.shape) - 2)
        u, v = at[..., 0] - corner[..., 0], at[..., 1] - corner[..., 1]
        row, column = corner[..., 0], corner[..., 1]
        low = (1.0 - v) * self.table[row, column] + v * self.table[row, column + 1]
        high = (1.0 - v) * self.table[row + 1, column] + v * self.table[row + 1, column + 1]
        return np.asarray((1.0 - u) * low + u * high)


def level_set(model: InteractionModel, threshold: float) -> LevelSet:
    """Return the zone of a law's downwash above `threshold` [m/s^2], for a level source at rest.

    Raises:
        ValueError: the downwash never reaches the threshold, so the zone would be empty.
    """
    from scipy.spatial import cKDTree  # half a second, which nodes with another zone do not need

    excess = _strength(model) - threshold
    if not (excess > 0.0).any():
        peak = float(excess.max()) + threshold
        raise ValueError(f"zone threshold = {threshold} m/s^2; must be below the downwash's peak, {peak:.3g}")
    nodes = np.indices(excess.shape).reshape(2, -1).T
    distance, _ = cKDTree(_crossings(excess)).query(nodes.astype(np.float64))
    table = np.where(excess > 0.0, -1.0, 1.0) * STEP * distance.reshape(excess.shape)
    return LevelSet(threshold=threshold, table=table)


def peak_downwash(model: InteractionModel) -> float:
    """Return the largest downwash of a law [m/s^2]; 0 without interaction."""
    return float(_strength(model).max())


def push_at_range(model: InteractionModel) -> float:
    """Return the largest downwash of a law at the end of its reach below [m/s^2], where zones end."""
    reach = model.reach.vertical
    return float(_strength(model)[:, _grid(reach) < reach + LAST].max(axis=0)[-1])


def _strength(model: InteractionModel) -> Array:
    """Return max(|eta(dr)|, |eta(-dr)|) on the grid, zero beyond the law's reach.

    The first grid point at or beyond the end of the reach has the value of that end.
    """
    reach = model.reach
    across, gap = _grid(reach.horizontal), _grid(reach.vertical)
    ends = np.minimum(across, reach.horizontal), [0.0], np.minimum(gap, reach.vertical)
    rel_pos = np.stack(np.meshgrid(*ends, indexing="ij"), axis=-1)[:, 0]  # (rows, columns, 3)
    pushes = [np.linalg.norm(downwash_at_rest(model, sign * rel_pos), axis=-1) for sign in (1.0, -1.0)]
    within = (across[:, None] < reach.horizontal + LAST) & (gap < reach.vertical + LAST)
    return np.where(within, np.maximum(*pushes), 0.0)


def _grid(reach: float) -> Array:
    """Return the grid points along an axis [m]."""
    return np.arange(0.0, reach + MARGIN + STEP, STEP)


def _crossings(excess: Array) -> Array:
    """Return the sign changes of `excess` on the edges of the grid, in grid steps, (k, 2)."""
    return np.concatenate([_along_columns(excess), _along_columns(excess.T)[:, ::-1]])


def _along_columns(excess: Array) -> Array:
    before, after = excess[:, :-1], excess[:, 1:]
    row, column = np.nonzero((before > 0.0) != (after > 0.0))
    share = before[row, column] / (before[row, column] - after[row, column])
    return np.stack([row.astype(np.float64), column + share], axis=-1)
