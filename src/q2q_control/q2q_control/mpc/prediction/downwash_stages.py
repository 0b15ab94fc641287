"""Lay out the pairs of a horizon for a law, and gather what it says: the loops of downwash_horizon, compiled.

| name | meaning [unit] |
|---|---|
| times pos first | of Tracks: (K,) [s], (K, n, 3) [m], index of the horizon's first stage |
| i j | pairs, i feels, j causes, (p,) |
| places | rel_pos of pairs and stages: itself, then + and - delta along each axis of moves, (m, p, N, 3) |
| law | what a model says at `places` [m/s^2], (m, p, N, 3) |
"""

import numpy as np
from numpy.typing import NDArray

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array

Rows = NDArray[np.intp]
Flags = NDArray[np.bool_]
Track = tuple[Array, Array, int]
"""times, pos, first."""


@compiled
def extent(path: Array) -> tuple[Array, Array]:
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
def meeting(path: Array, pairs: tuple[Rows, Rows], reach: tuple[float, float]) -> Flags:
    """Return which pairs come within reach (horizontal, vertical [m]) at some stage's middle, (p,)."""
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
def lay_out(
    tracks: Track,
    axis: Array,
    pairs: tuple[Rows, Rows],
    out: tuple[Array, Array, Array, Array],
) -> None:
    """Write places, and velocity and body z of the sources, velocity of who feels them, (m, p, N, 3) each."""
    times, pos, first = tracks
    i, j = pairs
    places, source_vel, source_axis, vel = out
    for p in range(i.size):
        for k in range(places.shape[2]):
            now, after = first + k, first + k + 1
            step = times[after] - times[now]
            for c in range(3):
                source = 0.5 * (pos[after, j[p], c] + pos[now, j[p], c])
                rel = source - 0.5 * (pos[after, i[p], c] + pos[now, i[p], c])
                moved = (pos[after, j[p], c] - pos[now, j[p], c]) / step
                own = (pos[after, i[p], c] - pos[now, i[p], c]) / step
                for m in range(places.shape[0]):
                    places[m, p, k, c], source_vel[m, p, k, c] = rel, moved
                    source_axis[m, p, k, c], vel[m, p, k, c] = axis[j[p], k, c], own


@compiled
def look_back(tracks: Track, pairs: tuple[Rows, Rows], delay: Array, places: Array) -> None:
    """Write places with the sources where they were a delay (p, N) [s] ago."""
    times, pos, first = tracks
    i, j = pairs
    for p in range(i.size):
        for k in range(delay.shape[1]):
            now, next_ = first + k, first + k + 1
            when = 0.5 * (times[next_] + times[now]) - delay[p, k]
            after = min(max(np.searchsorted(times, when), 1), times.size - 1)
            share = (when - times[after - 1]) / (times[after] - times[after - 1])
            share = min(max(share, 0.0), 1.0)
            for c in range(3):
                source = (1.0 - share) * pos[after - 1, j[p], c] + share * pos[after, j[p], c]
                rel = source - 0.5 * (pos[next_, i[p], c] + pos[now, i[p], c])
                for m in range(places.shape[0]):
                    places[m, p, k, c] = rel


@compiled
def nudge(places: Array, moves: Rows, delta: float) -> None:
    """Move the places 1, 2, ... along their axes, in place."""
    for a in range(moves.size):
        places[1 + 2 * a, :, :, moves[a]] += delta
        places[2 + 2 * a, :, :, moves[a]] -= delta


@compiled
def _largest(law: Array) -> float:
    """Return the largest magnitude, NaN where there is one."""
    largest = 0.0
    for value in law.flat:
        if np.isnan(value):
            return np.nan
        largest = max(largest, abs(value))
    return largest


@compiled
def gather(
    law: Array,
    pairs: tuple[Rows, Rows],
    rules: tuple[Rows, float, float, float],
    count: Array,
    out: tuple[Array, Array],
) -> Flags:
    """Sum eta (n, N, 3), write the slopes (p, N, 3, 3) of strong pairs, return which pairs are strong.

    Args:
        law: of all places.
        pairs: i and j.
        rules: moves, delta, faint, largest slope.
        count: weight of each source's downwash, (n, N).
        out: eta and slope.
    """
    i, j = pairs
    moves, delta, faint, slope_max = rules
    eta, slope = out
    strong = np.zeros(i.size, np.bool_)
    for p in range(i.size):
        strong[p] = _largest(law[0, p]) > faint  # False where a law is no number
        if not strong[p]:
            continue
        for k in range(law.shape[2]):
            share = count[j[p], k]
            for c in range(3):
                eta[i[p], k, c] += law[0, p, k, c] * share
                for a in range(moves.size):
                    rise = (law[1 + 2 * a, p, k, c] - law[2 + 2 * a, p, k, c]) / (2.0 * delta) * share
                    slope[p, k, c, moves[a]] = min(max(rise, -slope_max), slope_max)
    return strong
