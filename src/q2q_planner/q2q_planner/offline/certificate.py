"""Proof that no pair of a plan enters a zone, at any time, not only at samples.

Branch and bound over time. On a stretch of time the relative position dr(t) of a pair lies in the convex
hull of its Bernstein control points c_k, so for every unit n

    distance(dr(t), zone) >= min_k n.c_k - support(n)

holds for all t of the stretch (`convex_zone`). With n the zone's normal at the middle of the stretch the
bound is second order in its length. Stretches whose bound is above the least distance found so far are
discarded; the others are halved. The result is the clearance: a lower bound of the signed distance over all
pairs and all t, within TOLERANCE, less a bound of all rounding that grows with the coefficients
(`rounding_bound`), at least ROUNDING: it holds for the exact polynomials and for the setpoints that a player
computes from them. After their last waypoint vehicles are at rest; that time is covered by their last point.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from q2q_model.geometry.zone import Zone
from q2q_model.signals.values import Array
from q2q_model.trajectory.bernstein import control_points, halves
from q2q_model.trajectory.polynomials import SwarmPlan
from q2q_planner.offline.convex_zone import Lathe, lathe_around
from q2q_planner.offline.rounding_bound import DEEPEST, rounding_bound
from q2q_planner.offline.shared_pieces import SharedPieces, shared_pieces

TOLERANCE = 1e-5
"""How far the clearance may lie below the true least distance [m]."""

ROUNDING = 1e-9
"""Least slack for rounding [m]: 1e5 times the last bit of a position of 50 m."""

MOST_ROUNDING = 1.0
"""Rounding beyond which nothing is computed, so that nothing overflows [m]."""

MOST_STRETCHES = 10_000_000
"""Stretches beyond which a plan is not searched further, for its memory: a hundred vehicles have a tenth."""

LIKELY = 256
"""Number of nearest boxes evaluated first, for an initial least distance."""


@dataclass(frozen=True, slots=True)
class Certificate:
    """Proven clearance of a plan from a zone."""

    clearance: float
    """Lower bound of every pair's distance to the zone at any t [m]; infinite for one vehicle, -infinite if
    rounding is above MOST_ROUNDING, or there are more than MOST_STRETCHES."""
    pair: tuple[str, str] | None
    """The pair that comes nearest."""
    t: float
    """Time of its least distance [s]."""

    @property
    def holds(self) -> bool:
        """Return whether the plan is proven to stay out of the zone."""
        return self.clearance > ROUNDING


def certify(plan: SwarmPlan, zone: Zone, tolerance: float = TOLERANCE) -> Certificate:
    """Return the proven clearance of a plan from a zone."""
    if len(plan.names) < 2:
        return Certificate(np.inf, None, 0.0)
    rounding = max(ROUNDING, rounding_bound(plan.trajectories))
    if not rounding < MOST_ROUNDING:
        return Certificate(-np.inf, (plan.names[0], plan.names[1]), 0.0)
    lathe, shared = lathe_around(zone), shared_pieces(plan.trajectories)
    if len(shared.durations) * len(plan.names) * (len(plan.names) - 1) > 2 * MOST_STRETCHES:
        return Certificate(-np.inf, (plan.names[0], plan.names[1]), 0.0)
    stretches = _stretches(shared, lathe)
    bound, where = _least_distance(stretches, lathe, tolerance)
    first, second = (plan.names[row] for row in (stretches.first[where[0]], stretches.second[where[0]]))
    t = shared.starts[stretches.piece[where[0]]] + where[1] * shared.durations[stretches.piece[where[0]]]
    return Certificate(bound - rounding, (first, second), float(t))


def as_certified(plan: SwarmPlan, lathe: Lathe) -> SwarmPlan:
    """Return a plan marked as certified for a zone, of which its certificate was found to hold."""
    profile = tuple((float(radius), float(height)) for radius, height in lathe.profile)
    return replace(plan, certified=True, zone_profile=profile)


Rows = NDArray[np.intp]


@dataclass(frozen=True, slots=True, eq=False)
class _Stretches:
    """Pairs and pieces on which they may come close."""

    first: Rows
    second: Rows
    piece: Rows
    points: Array
    """Control points of the relative position [m], (stretches, 3, order)."""


def _stretches(shared: SharedPieces, lathe: Lathe) -> _Stretches:
    """Return the stretches that may contain the least distance: their boxes are nearer than some midpoint."""
    points = control_points(shared.coefficients, shared.durations[:, None, None])  # (pieces, n, 3, order)
    first, second = np.triu_indices(points.shape[1], 1)
    apart = _box_gaps(points, first, second, lathe)  # (pieces, pairs)
    likely = np.unravel_index(np.argsort(apart, axis=None)[:LIKELY], apart.shape)
    least = lathe.nearest(_midpoints(_relative(points, likely, first, second)))[1].min()
    piece, pair = near = np.nonzero(apart <= least)
    return _Stretches(first[pair], second[pair], piece, _relative(points, near, first, second))


def _box_gaps(points: Array, first: Rows, second: Rows, lathe: Lathe) -> Array:
    """Return a bound below the signed distance from the boxes of control points, (pieces, pairs)."""
    low, high = points.min(-1), points.max(-1)  # (pieces, n, 3)
    gap = np.maximum(low[:, first] - high[:, second], low[:, second] - high[:, first])  # (pieces, pairs, 3)
    clear = np.maximum(gap, 0.0)
    sideways = np.hypot(clear[..., 0], clear[..., 1]) - lathe.eps
    apart = np.maximum(sideways, clear[..., 2] - lathe.d)
    return np.where(apart > 0.0, apart, -np.inf)


def _relative(points: Array, which: tuple[Rows, ...], first: Rows, second: Rows) -> Array:
    piece, pair = which
    return np.asarray(points[piece, first[pair]] - points[piece, second[pair]])


def _least_distance(stretches: _Stretches, lathe: Lathe, tolerance: float) -> tuple[float, tuple[int, float]]:
    """Return a lower bound of the least distance, and (stretch, share of its piece) where it is met."""
    points, owner = stretches.points, np.arange(len(stretches.first))
    share, length = np.zeros(len(owner)), 1.0
    best, where, floor = np.inf, (0, 0.0), np.inf
    for _ in range(DEEPEST):
        middle = _midpoints(points)
        normal, distance = lathe.nearest(middle)
        nearest = int(distance.argmin())
        if distance[nearest] < best:
            best, where = (
                float(distance[nearest]),
                (int(owner[nearest]), float(share[nearest] + 0.5 * length)),
            )
        bound = _lower_bounds(points, normal, lathe, distance)
        open_ = bound < best - tolerance
        floor = min(floor, float(bound[~open_].min(initial=np.inf)))
        if not open_.any():
            return min(floor, best), where
        left, right = halves(points[open_])
        points = np.concatenate([left, right])
        owner = np.concatenate([owner[open_], owner[open_]])
        length *= 0.5
        share = np.concatenate([share[open_], share[open_] + length])
        if len(owner) > MOST_STRETCHES:
            break
    return min(floor, best, float(_lower_bounds(points, *_at_middle(points, lathe)).min())), where


def _at_middle(points: Array, lathe: Lathe) -> tuple[Array, Lathe, Array]:
    normal, distance = lathe.nearest(_midpoints(points))
    return normal, lathe, distance


def _midpoints(points: Array) -> Array:
    return np.asarray(halves(points)[0][..., -1])


def _lower_bounds(points: Array, normal: Array, lathe: Lathe, distance: Array) -> Array:
    """Return bounds below the signed distance on each stretch, (stretches,).

    A separating plane where the middle is outside; everywhere, the distance less the radius of the control
    points, because a signed distance is 1-Lipschitz.
    """
    plane = np.einsum("sak,sa->sk", points, normal).min(-1) - lathe.support(normal)
    reach = np.sqrt(((points - _midpoints(points)[..., None]) ** 2).sum(1)).max(-1)
    return np.asarray(np.where(distance > 0.0, np.maximum(plane, distance - reach), distance - reach))
