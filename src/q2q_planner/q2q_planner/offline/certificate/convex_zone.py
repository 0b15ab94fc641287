"""Convex solid of revolution that contains an interference zone; separation is proven for the solid.

A `ConvexZone` is the convex hull, revolved about the vertical and mirrored at dz = 0, of a few profile points
(radius, height). Its support function is exact, so any direction n gives a true statement:

    sup_{x in zone} n.x = max_k (|n_xy| radius_k + |n_z| height_k) = support(n)
    distance(x, zone) >= n.x - support(n)  for every unit n, with equality at the best n.

Every zone lies in its convex zone: a cylinder is one with a single profile point; any other shape is sampled
by height, and each piece of its profile gets a corner that contains it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from q2q_model.geometry.zone import Cylinder, Ellipsoid, Zone
from q2q_model.signals.values import Array

LARGEST = 5.0
"""Range in which a zone is searched, outwards and upwards [m]: far beyond any downwash measured."""

HEIGHT_STEP = 0.01
"""Thickness of the slices of a zone of unknown shape [m]; a slice gets the larger radius of its faces."""

TANGENTS = 16
"""Tangent planes, in a quarter turn, that wrap a round profile: its size grows by at most 0.12 %."""

SHORTEST_EDGE = 1e-9
"""Edges of a profile shorter than this are rounding [m]."""

BENT = 1e-6
"""Turns of a profile smaller than this are rounding [rad]: the last bit of 1 m over SHORTEST_EDGE."""


@dataclass(frozen=True, slots=True, eq=False)
class ConvexZone:
    """Convex solid of revolution; a Zone."""

    profile: Array
    """Corners (radius, height) [m] of the hull in the first quadrant, heights rising, (k, 2)."""

    @property
    def eps(self) -> float:
        """Return the largest radius [m]."""
        return float(self.profile[:, 0].max())

    @property
    def d(self) -> float:
        """Return the half height [m]."""
        return float(self.profile[:, 1].max())

    def support(self, normal: Array) -> Array:
        """Return sup n.x over the solid [m], (...,), for directions n (..., 3)."""
        across = np.hypot(normal[..., 0], normal[..., 1])
        along = np.abs(normal[..., 2])
        return np.asarray(
            (across[..., None] * self.profile[:, 0] + along[..., None] * self.profile[:, 1]).max(-1)
        )

    def signed_distance(self, rel_pos: Array) -> Array:
        """Return the distance to the surface [m], (...,), negative inside."""
        return self.nearest(rel_pos)[1]

    def nearest(self, rel_pos: Array) -> tuple[Array, Array]:
        """Return the outward unit normal at the nearest surface point (..., 3) and the distance (...,).

        On the axis, where the direction is not defined, the normal's horizontal part points along x.
        """
        across, height = np.hypot(rel_pos[..., 0], rel_pos[..., 1]), rel_pos[..., 2]
        flat = np.stack([across, np.abs(height)], axis=-1)  # (..., 2)
        start, step, outward = self._edges()
        beyond = flat[..., None, :] - start  # (..., edges, 2)
        depth = (beyond * outward).sum(-1)  # to each edge's line
        share = np.clip((beyond * step).sum(-1) / (step * step).sum(-1), 0.0, 1.0)
        gap = beyond - share[..., None] * step
        length = np.hypot(gap[..., 0], gap[..., 1])
        outside = depth.max(-1) > 0.0
        best = np.where(outside, length.argmin(-1), depth.argmax(-1))[..., None]
        distance = np.take_along_axis(np.where(outside[..., None], length, depth), best, -1)[..., 0]
        normal_2d = np.take_along_axis(outward, best.reshape(-1, 1), 0).reshape(*best.shape[:-1], 2)
        away = np.take_along_axis(gap, best[..., None], -2)[..., 0, :]
        far = outside & (distance > 1e-12)  # closer, the edge's own normal serves
        normal_2d = np.where(far[..., None], away / np.where(far, distance, 1.0)[..., None], normal_2d)
        return _revolved(rel_pos, across, normal_2d), distance

    def _edges(self) -> tuple[Array, Array, Array]:
        """Return start, step and outward unit normal of the profile's edges, (edges, 2) each."""
        corners = np.concatenate([[[self.profile[0, 0], 0.0]], self.profile, [[0.0, self.profile[-1, 1]]]])
        step = np.diff(corners, axis=0)
        real = np.hypot(step[:, 0], step[:, 1]) > SHORTEST_EDGE
        start, step = corners[:-1][real], step[real]
        return (
            start,
            step,
            np.stack([step[:, 1], -step[:, 0]], axis=-1) / np.hypot(step[:, 0], step[:, 1])[:, None],
        )


def zone_around(zone: Zone) -> ConvexZone:
    """Return a ConvexZone that contains a zone symmetric about the vertical: exact for a cylinder.

    Raises:
        ValueError: the zone is empty, or larger than LARGEST.
    """
    if isinstance(zone, ConvexZone):
        return zone
    if isinstance(zone, Cylinder):
        return ConvexZone(np.array([[zone.eps, zone.d]]))
    if isinstance(zone, Ellipsoid):
        axes = np.array([zone.eps, zone.d])
        normal = _directions(axes)
        return _wrapped(normal, np.hypot(*(normal * axes).T))
    heights = np.arange(0.0, LARGEST + HEIGHT_STEP, HEIGHT_STEP)
    radii = _radii(zone, heights)
    if not (radii > 0.0).any():
        raise ValueError("the zone is empty: nothing is inside it at dx = dy = 0")
    if radii.max() >= LARGEST or radii[-1] > 0.0:
        raise ValueError(f"the zone reaches beyond {LARGEST} m: give a smaller one")
    last = int(np.flatnonzero(radii > 0.0).max()) + 1  # the slice above the last radius is contained too
    widest = np.maximum(radii[:last], radii[1 : last + 1])
    corners = np.concatenate(
        [np.stack([widest, heights[:last]], -1), np.stack([widest, heights[1 : last + 1]], -1)]
    )
    normal = _directions(corners.max(axis=0))
    return _wrapped(normal, (normal @ corners.T).max(axis=1))


def zone_of_profile(corners: Sequence[tuple[float, float]]) -> ConvexZone:
    """Return the ConvexZone of a profile from elsewhere, corners (radius, height).

    Raises:
        ValueError: no radius, no height, or corners not in the order of a convex first quadrant.
    """
    made = ConvexZone(np.array(corners, dtype=np.float64).reshape(-1, 2))
    across, up = made.profile.max(axis=0, initial=0.0)
    if not min(across, up) > SHORTEST_EDGE or not (step := made._edges()[1]).size:  # noqa: SLF001
        size = f"the profile of the zone reaches {across:g} m across and {up:g} m up"
        raise ValueError(f"{size}: both, and one edge, must be longer than {SHORTEST_EDGE:g} m")
    along = step / np.hypot(step[:, 0], step[:, 1])[:, None]
    turns = along[:-1, 0] * along[1:, 1] - along[:-1, 1] * along[1:, 0]
    if (along[:, 0] > BENT).any() or (along[:, 1] < -BENT).any() or (turns < -BENT).any():
        raise ValueError("the profile of the zone is not convex, with rising heights and falling radii")
    return made


def zone_by_support(support: Callable[[Array], Array], size: Array) -> ConvexZone:
    """Return a ConvexZone around the solid of a support function of unit directions (k, 2) of its profile.

    `size` is about its radius and half height [m], (2,): directions are spread evenly on such a profile.
    """
    normal = _directions(size)
    normal /= np.hypot(normal[:, 0], normal[:, 1])[:, None]
    return _wrapped(normal, support(normal))


def _radii(zone: Zone, heights: Array) -> Array:
    """Return the radius within which the zone lies at each height [m]; 0 where it is absent."""
    low, high = np.zeros_like(heights), np.full_like(heights, LARGEST)
    inside = zone.signed_distance(np.stack([low, low, heights], -1)) <= 0.0
    coarse = np.arange(0.0, LARGEST, HEIGHT_STEP)
    grid = np.stack(np.meshgrid(coarse, [0.0], heights, indexing="ij"), -1)[:, 0]  # (radii, heights, 3)
    hit = zone.signed_distance(grid) <= 0.0
    inside |= hit.any(axis=0)
    outermost = len(coarse) - 1 - np.argmax(hit[::-1], axis=0)
    low = np.where(inside, coarse[outermost], 0.0)
    high = np.where(inside, low + HEIGHT_STEP, 0.0)
    for _ in range(30):  # 2^-30 of a step
        middle = 0.5 * (low + high)
        within = zone.signed_distance(np.stack([middle, np.zeros_like(middle), heights], -1)) <= 0.0
        low, high = np.where(within, middle, low), np.where(within, high, middle)
    return np.where(inside, high, 0.0)


def _directions(size: Array) -> Array:
    """Return outward directions (TANGENTS + 1, 2) spread evenly on a profile of this size (2,)."""
    angle = np.linspace(0.0, 0.5 * np.pi, TANGENTS + 1)
    normal = np.stack([np.cos(angle) * size[1], np.sin(angle) * size[0]], axis=-1)
    normal[0], normal[-1] = (1.0, 0.0), (0.0, 1.0)
    return normal


def _wrapped(normal: Array, reach: Array) -> ConvexZone:
    """Return the solid between the tangents normal.x = reach; neighbours meet in its corners."""
    pairs = np.stack([normal[:-1], normal[1:]], axis=1)
    corners = np.linalg.solve(pairs, np.stack([reach[:-1], reach[1:]], axis=1)[..., None])[..., 0]
    return ConvexZone(np.asarray(corners, dtype=np.float64))


def _revolved(rel_pos: Array, across: Array, normal_2d: Array) -> Array:
    """Turn normals in the half plane (..., 2) into the horizontal direction of rel_pos (..., 3)."""
    off_axis = across > 0.0
    safe = np.where(off_axis, across, 1.0)
    east = np.where(off_axis, rel_pos[..., 0] / safe, 1.0)
    north = np.where(off_axis, rel_pos[..., 1] / safe, 0.0)
    up = np.where(rel_pos[..., 2] < 0.0, -normal_2d[..., 1], normal_2d[..., 1])
    return np.stack([normal_2d[..., 0] * east, normal_2d[..., 0] * north, up], axis=-1)
