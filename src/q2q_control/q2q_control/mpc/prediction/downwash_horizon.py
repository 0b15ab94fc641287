"""Predict the downwash along the horizon, and its slopes as vehicles leave their last prediction.

The downwash of stage k are taken at its middle, where each vehicle is half-way between two stages of its last
predicted path. A source pushes from where it was a delay tau ago: in the past, or on its predicted path.

    rel_k = r_j(t_k - tau) - r_i(t_k)
    eta_i,k = sum_j s_j,k law(rel_k),  G_ij,k = s_j,k d law / d rel at rel_k

A source throws its air along the thrust it is predicted to have, and s_j,k as strongly as a hovering one: one
that is pushed down itself carries its weight and its downwash. G by central differences; in G a source's
path counts as if its push came at once. The delay is exact in eta itself, so nothing is off where the path is
the predicted one.

| symbol | name | meaning [unit] |
|---|---|---|
| i, j | i, j | who feels, who causes |
| eta | eta | downwash acceleration [m/s^2], world, (n, N, 3) |
| G | slope | [1/s^2], (pairs, N, 3, 3): row feels, column moves |
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from q2q_control.mpc.prediction.downwash_stages import extent, gather, lay_out, look_back, meeting, nudge
from q2q_model.downwash.interaction_model import InteractionModel, PairMotion, Reach
from q2q_model.downwash.pairs_in_reach import pairs_in_reach
from q2q_model.signals.values import Array

Rows = NDArray[np.intp]

DELTA = 1e-3
"""Step of the differences [m]: a fiftieth of downwash's width errs by 1e-4 of the slope."""
FAINT = 1e-4
"""A pair whose downwash stay below this [m/s^2] on the whole horizon is none."""
ALL_PAIRS = 4
"""Up to this many vehicles all pairs are looked at; above, a sweep over sorted x finds them."""


@dataclass(frozen=True, slots=True)
class Tracks:
    """Past and predicted positions of every vehicle."""

    times: Array
    """Rising [s], (K,): the past, then now, then the stages of the horizon."""
    pos: Array
    """[m], world, (K, n, 3)."""
    axis: Array
    """Predicted body z of each stage, unit length, world, (n, N, 3)."""
    trust: Array
    """How much each vehicle's downwash counts: 1 where it is seen, (n,)."""
    first: int
    """Index of the horizon's first stage."""
    strength: Array | None = None
    """s: each source's downwash over a hovering one's, (n, N); None is 1."""


@dataclass(frozen=True, slots=True)
class DownwashHorizon:
    """Predicted downwash accelerations and their slopes."""

    eta: Array
    i: Rows
    """(pairs,)"""
    j: Rows
    """(pairs,)"""
    slope: Array


@dataclass(frozen=True, slots=True)
class SlopeRule:
    """Selection of the slopes that are evaluated."""

    moves: tuple[int, ...]
    """Axes along which vehicles may move off their paths: 0 1 2 for x y z."""
    slope_max: float
    """Slopes are cut to +- this [1/s^2]."""


def predict_downwash(model: InteractionModel, tracks: Tracks, rule: SlopeRule) -> DownwashHorizon:
    """Return downwash and slopes along the horizon."""
    near = _near_pairs(model.reach, np.ascontiguousarray(tracks.pos[tracks.first :]))
    pairs = np.ascontiguousarray(near[0]), np.ascontiguousarray(near[1])  # one layout, one kernel
    if pairs[0].size == 0:
        return no_downwash(tracks)
    n, stages = tracks.axis.shape[:2]
    moves = np.array(rule.moves)
    law = _law_at_places(model, tracks, pairs, moves)
    count = np.ones((n, stages)) * tracks.trust[:, None]
    if tracks.strength is not None:
        count *= tracks.strength
    eta, slope = np.zeros((n, stages, 3)), np.zeros((pairs[0].size, stages, 3, 3))
    strong = gather(law, pairs, (moves, DELTA, FAINT, rule.slope_max), count, (eta, slope))
    if strong.all():
        return DownwashHorizon(eta, pairs[0], pairs[1], slope)
    return DownwashHorizon(eta, pairs[0][strong], pairs[1][strong], slope[strong])


def no_downwash(tracks: Tracks) -> DownwashHorizon:
    """Return what a controller that ignores downwash predicts."""
    none = np.zeros(0, np.intp)
    n, stages = tracks.axis.shape[:2]
    return DownwashHorizon(np.zeros((n, stages, 3)), none, none, np.zeros((0, stages, 3, 3)))


def _near_pairs(reach: Reach, path: Array) -> tuple[Rows, Rows]:
    """Return the ordered pairs that come within reach at some stage of `path` (N + 1, n, 3)."""
    n = path.shape[1]
    if reach.horizontal <= 0.0 or n < 2:
        return np.zeros(0, np.intp), np.zeros(0, np.intp)
    if n <= ALL_PAIRS:
        pairs = _all_pairs(n)
    else:
        centre, half = extent(path)
        aside = reach.horizontal + 2.0 * float(np.hypot(half[0], half[1]))
        pairs = pairs_in_reach(centre, Reach(aside, reach.vertical + 2.0 * float(half[2])))
    hit = meeting(path, pairs, (reach.horizontal, reach.vertical))
    return pairs if hit.all() else (pairs[0][hit], pairs[1][hit])


@lru_cache(maxsize=ALL_PAIRS)
def _all_pairs(n: int) -> tuple[Rows, Rows]:
    i, j = np.nonzero(~np.eye(n, dtype=np.bool_))
    return i, j


def _law_at_places(model: InteractionModel, tracks: Tracks, pairs: tuple[Rows, Rows], moves: Rows) -> Array:
    """Return the law of pairs where they will be, and DELTA beside, (1 + 2 moves, pairs, N, 3)."""
    track = (tracks.times, tracks.pos, tracks.first)
    shape = (1 + 2 * moves.size, pairs[0].size, tracks.axis.shape[1], 3)
    places, source_vel, source_axis, vel = (np.empty(shape) for _ in range(4))
    lay_out(track, tracks.axis, pairs, (places, source_vel, source_axis, vel))
    if model.max_delay > 0.0:
        look_back(track, pairs, model.delay(places[0]), places)
    nudge(places, moves, DELTA)
    return model.acceleration(places, PairMotion(source_vel, source_axis, vel))
