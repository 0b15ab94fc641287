"""Samples at which pairs of vehicles are near a zone.

Few pairs of a large swarm come near each other: boxes around runs of samples show which may, and only these
are looked at sample by sample.
"""

from itertools import pairwise

import numpy as np

from q2q_model.signals.values import Array, Mask, Rows
from q2q_planner.offline.certificate.convex_zone import ConvexZone

LOOK = 0.1
"""Samples within this many radii of the zone get a plane before they violate it."""
BOXED = 16
"""Samples of a box: its vehicle moves by up to four radii meanwhile, and few pairs are looked at closely."""


def pairs_near_zone(positions: Array, pairs: tuple[Rows, Rows], zone: ConvexZone) -> Mask:
    """Return which pairs may have a sample near the zone, (pairs,): boxes around BOXED samples are near.

    `positions` [m] are (S, n, 3); `first` of the pairs must rise.
    """
    runs = np.arange(0, len(positions), BOXED)
    low, high = (
        np.ascontiguousarray(end.reduceat(positions, runs).transpose(2, 1, 0))
        for end in (np.minimum, np.maximum)
    )  # (3, n, runs): a row for each vehicle
    begin = np.searchsorted(pairs[0], np.arange(positions.shape[1] + 1))
    meets = []
    for i, (start, end) in enumerate(pairwise(begin)):
        j = pairs[1][start:end]
        gap = np.maximum(low[:, i, None] - high[:, j], low[:, j] - high[:, i, None])
        meets.append(is_near(np.maximum(gap, 0.0), zone).any(axis=-1))
    return np.concatenate(meets)


def is_near(rel: Array, zone: ConvexZone) -> Mask:
    """Return which relative positions [m] (3, ...) are near the zone, (...,)."""
    look = LOOK * zone.eps
    near = rel[0] ** 2 + rel[1] ** 2 < (zone.eps + look) ** 2
    return np.asarray(near & (np.abs(rel[2]) < zone.d + look))


def cut_corners(positions: Array, pairs: tuple[Rows, Rows], zone: ConvexZone) -> Mask:
    """Return the deepest sample of every run of samples inside the zone, (pairs, S).

    Between two planes a pair may cut a corner of the zone that bends more than a sphere of its radius.
    `positions` [m] are (S, n, 3); `first` of the pairs must rise.
    """
    deepest = np.zeros((len(pairs[0]), len(positions)), np.bool_)
    for pair in np.flatnonzero(pairs_near_zone(positions, pairs, zone)):
        rel = positions[:, pairs[0][pair]] - positions[:, pairs[1][pair]]
        near = np.flatnonzero(is_near(rel.T, zone))
        distance = zone.nearest(rel[near])[1]
        inside = near[distance < 0.0]
        deepest[pair, deepest_of_runs(inside, -distance[distance < 0.0])] = True
    return deepest


def deepest_of_runs(sample: Rows, depth: Array) -> Rows:
    """Return the sample of largest depth of every run of consecutive samples, which rise; (k,) each."""
    return sample[deepest_rows(np.flatnonzero(np.diff(sample, prepend=-2) > 1), depth)]


def deepest_rows(begins: Rows, depth: Array) -> Rows:
    """Return the first row of largest depth of every run of rows, from its begin to the next; (k,)."""
    runs = pairwise([*begins.tolist(), len(depth)])
    return np.array([start + int(depth[start:end].argmax()) for start, end in runs], dtype=np.intp)
