"""Compiled loops of downwash_horizon: geometry of pairs along a horizon, and the sum of their downwash.

| name | meaning [unit] |
|---|---|
| pairs | i and j, (p,) each: i feels, j causes |
| law | downwash of a model at all places [m/s^2], (m, p, N, 3) |
"""

import math
from typing import NamedTuple

import numpy as np

from q2q_control.mpc.neighbours.constant_velocity import FAR
from q2q_control.mpc.problem.horizon import DownwashHorizon
from q2q_model.compiled import BORROWING, compiled
from q2q_model.downwash.sweep_and_prune import OrderedPairs
from q2q_model.geometry.pair_reach import SLACK
from q2q_model.signals.values import Array, Mask, Rows

DELTA = 1e-3
"""Step of the differences [m]: a fiftieth of downwash's width errs by 1e-4 of the gradient."""
LEAST_DOWNWASH = 1e-4
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


PlainTracks = tuple[Array, Array, Array, Array, int]
"""Fields of Tracks, which numba takes from Python in less than half the time."""


@compiled
def bounding_boxes(path: Array) -> tuple[Array, Array]:
    """Return the centre of each vehicle's bounding box (n, 3) and the largest half size (3,) [m].

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
def way_in_delay(swarm: PlainTracks, max_delay: float, spread: Array) -> Array:
    """Return how far each vehicle's air may have left from where it is at a stage [m], (n, 2): aside and up.

    Its fastest steps over the longest delay [s], at most all its steps, and the farthest point at which a
    mean over its `spread` [m], (n,), is taken. A step to or from FAR is none: the air of a vehicle without
    state reaches nobody.
    """
    tracks = Tracks(*swarm)
    times, pos, n = tracks.times, tracks.pos, tracks.pos.shape[1]
    fastest, length, way = np.zeros((n, 2)), np.zeros((n, 2)), np.empty((n, 2))
    for k in range(1, times.size if max_delay > 0.0 else 0):
        share = max_delay / (times[k] - times[k - 1])
        for v in range(n):
            x, y = pos[k, v, 0] - pos[k - 1, v, 0], pos[k, v, 1] - pos[k - 1, v, 1]
            aside, rise = math.sqrt(x * x + y * y), abs(pos[k, v, 2] - pos[k - 1, v, 2])
            if rise < 0.5 * FAR and math.isfinite(aside):
                fastest[v, 0] = max(fastest[v, 0], aside * share)
                fastest[v, 1] = max(fastest[v, 1], rise * share)
                length[v, 0] += aside
                length[v, 1] += rise
    for v in range(n):
        way[v, 0] = min(fastest[v, 0], length[v, 0]) + math.sqrt(6.0) * spread[v] + SLACK
        way[v, 1] = min(fastest[v, 1], length[v, 1]) + SLACK
    return way


@compiled
def may_reach(path: Array, pairs: OrderedPairs, reach: tuple[float, float], way: Array) -> Mask:
    """Return the pairs that may come within reach (horizontal, vertical [m]) at some stage's middle, (p,).

    `path` is (N + 1, n, 3) [m], and `way` (n, 2) that of `way_in_delay`.
    """
    i, j = pairs
    hit = np.zeros(i.size, np.bool_)
    rel = np.empty(3)
    for p in range(i.size):
        aside, up = reach[0] + way[j[p], 0], reach[1] + way[j[p], 1]
        for k in range(path.shape[0] - 1):
            for axis in range(3):
                source = 0.5 * (path[k + 1, j[p], axis] + path[k, j[p], axis])
                rel[axis] = source - 0.5 * (path[k + 1, i[p], axis] + path[k, i[p], axis])
            if rel[0] ** 2 + rel[1] ** 2 <= aside**2 and abs(rel[2]) <= up:
                hit[p] = True
                break
    return hit


@compiled
def displaced_places(places: Array, moves: Rows) -> Array:
    """Return places (p, N, 3), then moved by +DELTA, -DELTA along each of `moves`, (1 + 2 moves, p, N, 3)."""
    found = np.empty((1 + 2 * moves.size, *places.shape))
    for m in range(found.shape[0]):
        found[m] = places
    for a in range(moves.size):
        found[1 + 2 * a, ..., moves[a]] += DELTA
        found[2 + 2 * a, ..., moves[a]] -= DELTA
    return found


@compiled
def sum_downwash(law: Array, weight: Array, moves: Rows, slope_max: float, out: DownwashHorizon) -> Mask:
    """Add the downwash of pairs to `out.eta`, write their gradients; return those that are not faint, (p,).

    `weight` is that of Tracks, (n, N); `moves` are the axes of displacement, x y z as 0 1 2, and `slope_max`
    is the largest gradient [1/s^2].
    """
    strong = np.zeros(out.i.size, np.bool_)
    for p in range(out.i.size):
        strong[p] = is_strong(law[0, p])
        if strong[p]:
            add_pair(law[:, p], weight, (moves, slope_max), p, out)
    return strong


@compiled(**BORROWING)
def add_pair(law: Array, weight: Array, gradients: tuple[Rows, float], p: int, out: DownwashHorizon) -> None:
    """Add the downwash (m, N, 3) of pair p at all places to `out.eta`, and write its gradients.

    `weight` is as in `sum_downwash`; `gradients` are its `moves` and `slope_max`.
    """
    moves, slope_max = gradients
    i, j = out.i[p], out.j[p]
    for k in range(law.shape[1]):
        share = weight[j, k]
        for c in range(3):
            out.eta[i, k, c] += law[0, k, c] * share
            for a in range(moves.size):
                rise = (law[1 + 2 * a, k, c] - law[2 + 2 * a, k, c]) / (2.0 * DELTA) * share
                out.gradient[p, k, c, moves[a]] = min(max(rise, -slope_max), slope_max)


@compiled(**BORROWING)
def is_strong(law: Array) -> bool:
    """Return whether a downwash (N, 3) [m/s^2] counts; one that is not a number at some stage does not."""
    largest = 0.0
    for k in range(law.shape[0]):
        for c in range(3):
            if np.isnan(law[k, c]):
                return False
            largest = max(largest, abs(law[k, c]))
    return largest > LEAST_DOWNWASH
