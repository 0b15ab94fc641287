"""Proof that no pair of a plan enters a zone, at any time, not only at samples.

On a stretch of time the relative position dr(t) of a pair lies in the convex
hull of its Bernstein control points c_k, so for every unit n

    distance(dr(t), zone) >= min_k n.c_k - support(n)

holds for all t of the stretch (`convex_zone`). With n the zone's normal at the middle of the stretch the
bound is second order in its length (`branch_and_bound`). The result is the clearance: a lower bound of the
signed distance over all pairs and all t, within TOLERANCE, less a bound of all rounding that grows with the
coefficients (`rounding_bound`): it holds for the exact polynomials and for the setpoints that a player
computes from them. After their last waypoint vehicles are at rest; that time is covered by their last point.
"""

from dataclasses import dataclass, replace

import numpy as np

from q2q_model.geometry.zone import Zone
from q2q_model.signals.values import Array, Rows
from q2q_model.trajectory.bernstein import control_points, split_in_half
from q2q_model.trajectory.polynomials import SwarmPlan
from q2q_planner.offline.certificate.branch_and_bound import MOST_STRETCHES, StretchBounds, least_on_stretches
from q2q_planner.offline.certificate.convex_zone import ConvexZone, zone_around
from q2q_planner.offline.certificate.rounding_bound import (
    MOST_ROUNDING,
    NOT_BOUNDED,
    ROUNDING,
    rounding_slack,
)
from q2q_planner.offline.certificate.shared_pieces import SharedPieces, shared_pieces

LIKELY = 256
"""Number of nearest boxes evaluated first, for an initial smallest distance."""


@dataclass(frozen=True, slots=True)
class Certificate:
    """Proven clearance of a plan from a zone."""

    clearance: float
    """Lower bound of every pair's distance to the zone at any t [m]; infinite for one vehicle, -infinite if
    none is computed."""
    pair: tuple[str, str] | None
    """The pair that comes nearest."""
    t: float
    """Time of its smallest distance [s]."""
    not_computed: str = ""
    """Why no clearance is computed; empty where one is."""

    @property
    def holds(self) -> bool:
        """Return whether the plan is proven to stay out of the zone."""
        return self.clearance > ROUNDING


def certify(plan: SwarmPlan, zone: Zone, enough: float = -np.inf) -> Certificate:
    """Return the proven clearance of a plan from a zone.

    A distance of `enough` [m] or less ends the search: the clearance is -inf then, the plan does not hold.
    """
    if len(plan.names) < 2:
        return Certificate(np.inf, None, 0.0)
    rounding = rounding_slack(plan.trajectories)
    if not rounding < MOST_ROUNDING:
        return _without_clearance(plan, NOT_BOUNDED)
    hull, shared = zone_around(zone), shared_pieces(plan.trajectories)
    count = len(shared.durations) * len(plan.names) * (len(plan.names) - 1) // 2
    if count > MOST_STRETCHES:
        words = (
            f"{len(shared.durations)} pieces of {len(plan.names)} vehicles have {count} stretches of pairs"
        )
        return _without_clearance(plan, f"{words}, more than {MOST_STRETCHES}")
    stretches = _stretches(shared, hull, rounding)
    found = least_on_stretches(stretches.points, lambda points: _stretch_bounds(points, hull), enough=enough)
    pair = plan.names[stretches.first[found.row]], plan.names[stretches.second[found.row]]
    piece = stretches.piece[found.row]
    t = shared.starts[piece] + found.share * shared.durations[piece]
    return Certificate(found.bound - rounding, pair, float(t))


def _without_clearance(plan: SwarmPlan, why: str) -> Certificate:
    return Certificate(-np.inf, (plan.names[0], plan.names[1]), 0.0, why)


def as_certified(plan: SwarmPlan, zone: ConvexZone) -> SwarmPlan:
    """Return a plan marked as certified for a zone, of which its certificate was found to hold."""
    profile = tuple((float(radius), float(height)) for radius, height in zone.profile)
    return replace(plan, certified=True, zone_profile=profile)


@dataclass(frozen=True, slots=True, eq=False)
class _Stretches:
    """Pairs and pieces on which they may come close."""

    first: Rows
    second: Rows
    piece: Rows
    points: Array
    """Control points of the relative position [m], (stretches, 3, order)."""


def _stretches(shared: SharedPieces, zone: ConvexZone, rounding: float) -> _Stretches:
    """Return the stretches that may contain the smallest distance: their boxes are nearer than some midpoint.

    Box and midpoint of vehicles at rest are one distance, computed twice: `rounding` [m] covers both errors.
    """
    points = control_points(shared.coefficients, shared.durations[:, None, None])  # (pieces, n, 3, order)
    first, second = np.triu_indices(points.shape[1], 1)
    apart = _box_gaps(points, first, second, zone)  # (pieces, pairs)
    likely = np.unravel_index(np.argsort(apart, axis=None)[:LIKELY], apart.shape)
    least = zone.nearest(_midpoints(_relative(points, likely, first, second)))[1].min()
    piece, pair = near = np.nonzero(apart <= least + rounding)
    return _Stretches(first[pair], second[pair], piece, _relative(points, near, first, second))


def _box_gaps(points: Array, first: Rows, second: Rows, zone: ConvexZone) -> Array:
    """Return a bound below the signed distance from the boxes of control points, (pieces, pairs)."""
    low, high = points.min(-1), points.max(-1)  # (pieces, n, 3)
    gap = np.maximum(low[:, first] - high[:, second], low[:, second] - high[:, first])  # (pieces, pairs, 3)
    clear = np.maximum(gap, 0.0)
    sideways = np.hypot(clear[..., 0], clear[..., 1]) - zone.eps
    apart = np.maximum(sideways, clear[..., 2] - zone.d)
    return np.where(apart > 0.0, apart, -np.inf)


def _relative(points: Array, which: tuple[Rows, ...], first: Rows, second: Rows) -> Array:
    piece, pair = which
    return np.asarray(points[piece, first[pair]] - points[piece, second[pair]])


def _midpoints(points: Array) -> Array:
    return np.asarray(split_in_half(points)[0][..., -1])


def _stretch_bounds(points: Array, zone: ConvexZone) -> StretchBounds:
    """Return the distance to the zone in the middle of each stretch, and its lower bound on all of it.

    A separating plane where the middle is outside; everywhere, the distance less the radius of the control
    points, because a signed distance is 1-Lipschitz.
    """
    middle = _midpoints(points)
    normal, distance = zone.nearest(middle)
    plane = np.einsum("sak,sa->sk", points, normal).min(-1) - zone.support(normal)
    sphere = distance - np.sqrt(((points - middle[..., None]) ** 2).sum(1)).max(-1)
    lower = np.where(distance > 0.0, np.maximum(plane, sphere), sphere)
    return StretchBounds(distance, np.full(len(points), 0.5), lower)
