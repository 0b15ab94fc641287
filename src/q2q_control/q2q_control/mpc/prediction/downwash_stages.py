"""Compiled loops of downwash_horizon: geometry of pairs along a horizon, and the sum of their downwash.

| name | meaning [unit] |
|---|---|
| pairs | i and j, (p,) each: i feels, j causes |
| law | downwash of a model at all places [m/s^2], (m, p, N, 3) |
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array

Rows = NDArray[np.intp]
Flags = NDArray[np.bool_]
Pairs = tuple[Rows, Rows]

DELTA = 1e-3
"""Step of the differences [m]: a fiftieth of downwash's width errs by 1e-4 of the slope."""
FAINT = 1e-4
"""Pairs whose downwash stays below this [m/s^2] on the whole horizon are dropped."""


class Tracks(NamedTuple):
    """Past and predicted positions of every vehicle."""

    times: Array
    """Rising [s], (K,): the past, then now, then the stages of the horizon."""
    pos: Array
    """[m], world, (K, n, 3)."""
    axis: Array
    """Predicted body z of each stage, unit length, world, (n, N, 3)."""
    weight: Array
    """Factor on each source's downwash, (n, N): 1 for a visible vehicle that hovers."""
    first: int
    """Index of the horizon's first stage."""


class DownwashHorizon(NamedTuple):
    """Predicted downwash accelerations and their slopes."""

    eta: Array
    """[m/s^2], world, (n, N, 3)."""
    i: Rows
    """(p,)"""
    j: Rows
    """(p,)"""
    slope: Array
    """[1/s^2], (p, N, 3, 3): row feels, column moves."""


class Places(NamedTuple):
    """Stages of pairs, and the same displaced by + and - DELTA along m axes."""

    rel_pos: Array
    """[m], (1 + 2 m, p, N, 3)."""
    source_vel: Array
    """[m/s], the same shape."""
    source_axis: Array
    vel: Array
    """Of the vehicle that feels it [m/s]."""


@compiled
def bounding_boxes(path: Array) -> tuple[Array, Array]:
    """Return the centre of each vehicle's bounding box (n, 3) and the largest half size (3,).

    The box holds the midpoints of the stages of a path (N + 1, n, 3).
    """
    stages, n = path.shape[0] - 1, path.shape[1]
    centre, half = np.empty((n, 3)), np.zeros(3)
    for v in range(n):
        for axis in range(3):
            low, high = np.inf, -np.inf
            for k in range(stages):
                middle = 0.5 * (path[k + 1, v, axis] + path[k, v, axis])
                if np.isnan(middle):
                    low, high = np.nan, np.nan
                    break
                low, high = min(low, middle), max(high, middle)
            centre[v, axis] = 0.5 * (low + high)
            half[axis] = max(half[axis], 0.5 * (high - low))
    return centre, half


@compiled
def within_reach(path: Array, pairs: Pairs, reach: tuple[float, float]) -> Flags:
    """Return the pairs that come within reach (horizontal, vertical [m]) at some stage's middle, (p,)."""
    i, j = pairs
    hit = np.zeros(i.size, np.bool_)
    rel = np.empty(3)
    for p in range(i.size):
        for k in range(path.shape[0] - 1):
            for axis in range(3):
                source = 0.5 * (path[k + 1, j[p], axis] + path[k, j[p], axis])
                rel[axis] = source - 0.5 * (path[k + 1, i[p], axis] + path[k, i[p], axis])
            if rel[0] ** 2 + rel[1] ** 2 <= reach[0] ** 2 and abs(rel[2]) <= reach[1]:
                hit[p] = True
                break
    return hit


@compiled
def fill_places(tracks: Tracks, pairs: Pairs, places: Places) -> None:
    """Write the places of pairs, all of them not displaced."""
    i, j = pairs
    pos = tracks.pos
    for p in range(i.size):
        for k in range(places.rel_pos.shape[2]):
            now, after = tracks.first + k, tracks.first + k + 1
            step = tracks.times[after] - tracks.times[now]
            for c in range(3):
                source = 0.5 * (pos[after, j[p], c] + pos[now, j[p], c])
                rel = source - 0.5 * (pos[after, i[p], c] + pos[now, i[p], c])
                moved = (pos[after, j[p], c] - pos[now, j[p], c]) / step
                own = (pos[after, i[p], c] - pos[now, i[p], c]) / step
                for m in range(places.rel_pos.shape[0]):
                    places.rel_pos[m, p, k, c], places.source_vel[m, p, k, c] = rel, moved
                    places.source_axis[m, p, k, c], places.vel[m, p, k, c] = tracks.axis[j[p], k, c], own


@compiled
def delay_sources(tracks: Tracks, pairs: Pairs, delay: Array, rel_pos: Array) -> None:
    """Overwrite rel_pos (m, p, N, 3) with the sources where they were a delay (p, N) [s] ago."""
    times, pos = tracks.times, tracks.pos
    i, j = pairs
    for p in range(i.size):
        for k in range(delay.shape[1]):
            now, next_ = tracks.first + k, tracks.first + k + 1
            when = 0.5 * (times[next_] + times[now]) - delay[p, k]
            after = min(max(np.searchsorted(times, when), 1), times.size - 1)
            share = (when - times[after - 1]) / (times[after] - times[after - 1])
            share = min(max(share, 0.0), 1.0)
            for c in range(3):
                source = (1.0 - share) * pos[after - 1, j[p], c] + share * pos[after, j[p], c]
                rel = source - 0.5 * (pos[next_, i[p], c] + pos[now, i[p], c])
                for m in range(rel_pos.shape[0]):
                    rel_pos[m, p, k, c] = rel


@compiled
def displace(rel_pos: Array, moves: Rows) -> None:
    """Displace places 1, 2, ... by + and - DELTA along each axis of `moves`, in place."""
    for a in range(moves.size):
        rel_pos[1 + 2 * a, :, :, moves[a]] += DELTA
        rel_pos[2 + 2 * a, :, :, moves[a]] -= DELTA


@compiled
def sum_downwash(law: Array, weight: Array, moves: Rows, slope_max: float, out: DownwashHorizon) -> Flags:
    """Add the downwash of pairs to `out.eta` and write their slopes; return the pairs that are not faint.

    `weight` is that of Tracks. A pair whose law is not a number counts as faint.
    """
    strong = np.zeros(out.i.size, np.bool_)
    for p in range(out.i.size):
        strong[p] = _largest(law[0, p]) > FAINT
        if not strong[p]:
            continue
        i, j = out.i[p], out.j[p]
        for k in range(law.shape[2]):
            share = weight[j, k]
            for c in range(3):
                out.eta[i, k, c] += law[0, p, k, c] * share
                for a in range(moves.size):
                    rise = (law[1 + 2 * a, p, k, c] - law[2 + 2 * a, p, k, c]) / (2.0 * DELTA) * share
                    out.slope[p, k, c, moves[a]] = min(max(rise, -slope_max), slope_max)
    return strong


@compiled
def _largest(law: Array) -> float:
    """Return the largest magnitude, or NaN if any value is NaN."""
    largest = 0.0
    for value in law.flat:
        if np.isnan(value):
            return np.nan
        largest = max(largest, abs(value))
    return largest
