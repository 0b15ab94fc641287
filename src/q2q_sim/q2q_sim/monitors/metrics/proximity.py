"""How near the vehicles of a flight come to each other, over all ticks and pairs.

Positions are (T, n, 3) [m], world; a vehicle whose position is unknown (NaN) is near nobody.
"""

import math

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.geometry.zone import Cylinder
from q2q_model.signals.values import Array, Mask


def least_distances(pos: Array) -> Array:
    """Return how near each pair i < j comes [m], (n, n); infinite for others, and those never known."""
    return np.asarray(nearest_of_pairs(np.ascontiguousarray(pos)))


def any_in_zone(pos: Array, zone: Cylinder) -> Mask:
    """Return the ticks at which any pair is in the zone, (T,)."""
    return pairs_within(np.ascontiguousarray(pos), zone.eps, zone.d)[0]


def under_another(pos: Array, aside: float, below: float) -> Mask:
    """Return which vehicles are nearer than `aside` and up to `below` [m] below another, (T, n)."""
    return np.asarray(has_other_above(np.ascontiguousarray(pos), aside, below))


def in_zone_once(pos: Array, zone: Cylinder) -> list[tuple[int, int]]:
    """Return the pairs i < j of vehicles at pos (T, n, 3) [m] that are in the zone at any tick."""
    i, j = np.nonzero(pairs_within(np.ascontiguousarray(pos), zone.eps, zone.d)[1])
    return list(zip(i.tolist(), j.tolist(), strict=True))


def near_sample(pos: Array, samples: Array, reach: float) -> Mask:
    """Return which vehicles are nearer than `reach` [m] to any sample of their tick (T, m, 3), (T, n)."""
    return np.asarray(has_near_sample(np.ascontiguousarray(pos), np.ascontiguousarray(samples), reach))


@compiled
def nearest_of_pairs(pos: Array) -> Array:
    """Return how near each pair i < j comes [m], (n, n)."""
    n = pos.shape[1]
    least = np.full((n, n), math.inf)
    for k in range(pos.shape[0]):
        for i in range(n):
            x, y, z = pos[k, i]
            for j in range(i + 1, n):
                dx, dy, dz = pos[k, j, 0] - x, pos[k, j, 1] - y, pos[k, j, 2] - z
                square = dx * dx + dy * dy + dz * dz
                least[i, j] = min(least[i, j], square)
    return np.asarray(np.sqrt(least))


@compiled
def pairs_within(pos: Array, eps: float, d: float) -> tuple[Mask, Mask]:
    """Return the ticks (T,) and pairs i < j (n, n) nearer than eps [m] horizontally and d vertically."""
    count, n = pos.shape[:2]
    ticks, pairs = np.zeros(count, dtype=np.bool_), np.zeros((n, n), dtype=np.bool_)
    for k in range(count):
        for i in range(n):
            x, y, z = pos[k, i]
            for j in range(i + 1, n):
                dx, dy, dz = pos[k, j, 0] - x, pos[k, j, 1] - y, pos[k, j, 2] - z
                if dx * dx + dy * dy < eps * eps and abs(dz) < d:
                    ticks[k] = pairs[i, j] = True
    return ticks, pairs


@compiled
def has_other_above(pos: Array, aside: float, below: float) -> Mask:
    """Return which vehicles have another above them, (T, n); arguments as of `under_another`."""
    found = np.zeros(pos.shape[:2], dtype=np.bool_)
    for k in range(pos.shape[0]):
        for i in range(pos.shape[1]):
            for j in range(pos.shape[1]):
                dx, dy, dz = (
                    pos[k, j, 0] - pos[k, i, 0],
                    pos[k, j, 1] - pos[k, i, 1],
                    pos[k, j, 2] - pos[k, i, 2],
                )
                found[k, i] |= 0.0 < dz < below and dx * dx + dy * dy < aside * aside
    return found


@compiled
def has_near_sample(pos: Array, samples: Array, reach: float) -> Mask:
    """Return which vehicles are near a sample, (T, n); arguments as of `near_sample`."""
    found = np.zeros(pos.shape[:2], dtype=np.bool_)
    for k in range(pos.shape[0]):
        for i in range(pos.shape[1]):
            x, y, z = pos[k, i]
            for j in range(samples.shape[1]):
                dx, dy, dz = samples[k, j, 0] - x, samples[k, j, 1] - y, samples[k, j, 2] - z
                found[k, i] |= dx * dx + dy * dy + dz * dz < reach * reach
    return found
