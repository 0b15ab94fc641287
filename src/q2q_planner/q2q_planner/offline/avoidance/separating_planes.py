"""Separating planes for every pair near a zone: the linearisation of eq. (18).

Outside or slightly inside, a sample's plane touches the zone at its nearest point. A pass deeper than DEEP
gets one plane for all its samples inside, normal to the relative velocity at its deepest point: nearest
points would push one half of the pass backwards and the other half forwards.

Between planes a curve may cut the corner; if the pair moves by ds from one plane to the next, the planes are
offset by the sagitta ds^2 / (8 eps) of a chord of the zone's radius.
"""

from dataclasses import dataclass

import numpy as np

from q2q_model.signals.values import Array, Mask, Rows
from q2q_planner.offline.avoidance.near_samples import deepest_rows, is_near, pairs_near_zone
from q2q_planner.offline.certificate.convex_zone import ConvexZone

SPACING = 0.25
"""Distance between the planes of a pair, in radii."""
DEEP = 0.25
"""Depth of a pass, in radii, beyond which it gets one common plane."""
HEAD_ON = 1e-6
"""Miss distance below which a pass is head on [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class Sides:
    """Sides on which pairs get their deep passes."""

    sign: Array
    """-1 where a deep pass changes sides, (pairs,)."""
    vertical: bool = False
    """Whether vehicle i passes over j (under, where the sign is -1), in place of beside."""


@dataclass(frozen=True, slots=True, eq=False)
class Planes:
    """m half-spaces."""

    first: Rows
    """Vehicle i, (m,)."""
    second: Rows
    """Vehicle j, (m,)."""
    sample: Rows
    """Row s of the samples, (m,)."""
    normal: Array
    """Unit normal n, (m, 3)."""
    level: Array
    """[m], (m,)."""


@dataclass(frozen=True, slots=True, eq=False)
class Watch:
    """Samples of pairs that have come near the zone, sorted by pair, then sample."""

    pair: Rows
    """(w,)"""
    sample: Rows
    """(w,)"""
    rel: Array
    """r_i - r_j [m], (w, 3)."""
    passing: Rows
    """Index of a pair's pass by the zone, (w,)."""
    chord: Array
    """Change of r_i - r_j from the previous to the next sample [m], (w, 3)."""
    normal: Array
    """Outward normal at the zone's nearest point, (w, 3)."""
    distance: Array
    """Signed distance to the zone [m], (w,)."""


def watch_pairs(positions: Array, pairs: tuple[Rows, Rows], zone: ConvexZone, watched: Mask) -> Watch:
    """Return the samples near the zone, thinned to SPACING, and those `watched` already.

    Args:
        positions: of all vehicles at all samples [m], (S, n, 3).
        pairs: vehicles i and j of each pair.
        zone: that every pair keeps out of.
        watched: samples to include in any case, (pairs, S).
    """
    first, second = pairs
    seen = [np.empty((3, 0), dtype=np.intp)]  # pair, sample, passing
    for pair in np.flatnonzero(pairs_near_zone(positions, pairs, zone) | watched.any(axis=1)):
        rel = positions[:, first[pair]] - positions[:, second[pair]]
        near = is_near(rel.T, zone)
        sample = np.flatnonzero(watched[pair] | near & _thinned(rel, SPACING * zone.eps))
        passing = np.cumsum(near & np.diff(near, prepend=False), dtype=np.intp)[sample]
        seen.append(np.stack([np.full_like(sample, pair), sample, passing]))
    return _watch(positions, pairs, zone, np.concatenate(seen, axis=1))


def _watch(positions: Array, pairs: tuple[Rows, Rows], zone: ConvexZone, seen: Rows) -> Watch:
    """Return the samples `seen` (pair, sample, passing), (3, w)."""
    pair_of, sample, passing = seen
    i, j, last = pairs[0][pair_of], pairs[1][pair_of], len(positions) - 1
    rel = positions[sample, i] - positions[sample, j]
    before, after = np.maximum(sample - 1, 0), np.minimum(sample + 1, last)
    chord = positions[after, i] - positions[after, j] - positions[before, i] + positions[before, j]
    normal, distance = zone.nearest(rel)
    return Watch(pair_of, sample, rel, passing, chord, normal, distance)


def _thinned(rel: Array, spacing: float) -> Mask:
    """Return the samples at which a pair has moved by another `spacing` [m], (S,)."""
    path = np.concatenate([[0.0], np.cumsum(np.sqrt((np.diff(rel, axis=0) ** 2).sum(-1)))])
    count = np.floor(path / spacing)
    return np.concatenate([[True], count[1:] > count[:-1]])


def planes_of(
    watch: Watch, pairs: tuple[Rows, Rows], zone: ConvexZone, margin: float, sides: Sides
) -> Planes:
    """Return one plane a watched sample."""
    normal = _with_common_normals(watch, zone, sides)
    apart = np.maximum(SPACING * zone.eps, 0.5 * np.sqrt((watch.chord**2).sum(-1)))
    level = zone.support(normal) + margin + apart**2 / (8.0 * zone.eps)
    return Planes(pairs[0][watch.pair], pairs[1][watch.pair], watch.sample, normal, level)


def _with_common_normals(watch: Watch, zone: ConvexZone, sides: Sides) -> Array:
    """Return the normals with those of each deep pass replaced by one across the relative velocity."""
    inside = np.flatnonzero(watch.distance < 0.0)
    if not len(inside):
        return watch.normal
    pair, passing = watch.pair[inside], watch.passing[inside]
    begins = (np.diff(pair, prepend=-1) != 0) | (np.diff(passing, prepend=-1) != 0)
    deepest = inside[deepest_rows(np.flatnonzero(begins), -watch.distance[inside])]
    run = np.cumsum(begins) - 1
    normals = _upward if sides.vertical else _across
    across = normals(watch.rel[deepest], watch.chord[deepest]) * sides.sign[watch.pair[deepest]][:, None]
    deep = watch.distance[deepest] < -DEEP * zone.eps
    normal = watch.normal.copy()
    normal[inside[deep[run]]] = across[run[deep[run]]]
    return normal


def _upward(_: Array, chord: Array) -> Array:
    """Return upward units (k, 3) normal to the motion; across it if that is vertical."""
    square = np.maximum((chord**2).sum(-1, keepdims=True), np.finfo(np.float64).tiny)
    up = np.array([0.0, 0.0, 1.0]) - chord * chord[:, 2:] / square
    size = np.sqrt((up**2).sum(-1, keepdims=True))
    return np.where(size > HEAD_ON, up / np.maximum(size, HEAD_ON), [[1.0, 0.0, 0.0]])


def _across(rel: Array, chord: Array) -> Array:
    """Return horizontal units (k, 3) normal to the motion, towards rel; to the right if head on."""
    speed = np.hypot(chord[:, 0], chord[:, 1])
    moving = speed > 0.0
    along = np.where(moving[:, None], chord[:, :2] / np.where(moving, speed, 1.0)[:, None], 0.0)
    miss = rel[:, :2] - (rel[:, :2] * along).sum(-1, keepdims=True) * along
    size = np.hypot(miss[:, 0], miss[:, 1])
    right = np.where(moving[:, None], np.stack([along[:, 1], -along[:, 0]], -1), [[1.0, 0.0]])
    clear = (size > HEAD_ON)[:, None]
    flat = np.where(clear, miss / np.where(clear, size[:, None], 1.0), right)
    return np.concatenate([flat, np.zeros((len(flat), 1))], axis=1)
