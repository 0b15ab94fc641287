"""Predict the drafts along the horizon, and how they change when the vehicles move off their last prediction.

The drafts of stage k are taken at its middle, where each vehicle is half-way between two stages of its last
predicted path. A source pushes from where it was a delay tau ago: in the past, or on its predicted path.

    rel_k = r_j(t_k - tau) - r_i(t_k)
    eta_i,k = sum_j s_j,k law(rel_k),  G_ij,k = s_j,k d law / d rel at rel_k

A source throws its air along the thrust it is predicted to have, and s_j,k as strongly as a hovering one: one
that is pushed down itself carries its weight and its draft. G by central differences; in G a source's
path counts as if its push came at once. The delay is exact in eta itself, so nothing is off where the path is
the predicted one.

| symbol | name | meaning [unit] |
|---|---|---|
| i, j | i, j | who feels, who causes |
| eta | eta | draft acceleration [m/s^2], world, (n, N, 3) |
| G | slope | [1/s^2], (pairs, N, 3, 3): row feels, column moves |
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from q2q_model.interaction.model import InteractionModel, PairMotion, Reach
from q2q_model.neighbours import pairs_in_reach
from q2q_model.signals import Array

Rows = NDArray[np.intp]

DELTA = 1e-3
"""Step of the differences [m]: a fiftieth of a draft's width errs by 1e-4 of the slope."""
FAINT = 1e-4
"""A pair whose drafts stay below this [m/s^2] on the whole horizon is none."""
ALL_PAIRS = 4
"""Up to this many vehicles all pairs are looked at; above, a sweep over sorted x finds them."""


@dataclass(frozen=True, slots=True)
class Tracks:
    """Hold where every vehicle was and will be."""

    times: Array
    """Rising [s], (K,): the past, then now, then the stages of the horizon."""
    pos: Array
    """[m], world, (K, n, 3)."""
    axis: Array
    """Predicted body z of each stage, unit length, world, (n, N, 3)."""
    trust: Array
    """How much each vehicle's draft counts: 1 where it is seen, (n,)."""
    first: int
    """Index of the horizon's first stage."""
    strength: Array | None = None
    """s: each source's draft over a hovering one's, (n, N); None is 1."""


@dataclass(frozen=True, slots=True)
class DraftHorizon:
    """Hold the predicted drafts and their slopes."""

    eta: Array
    i: Rows
    """(pairs,)"""
    j: Rows
    """(pairs,)"""
    slope: Array


@dataclass(frozen=True, slots=True)
class SlopeRule:
    """Say which slopes are wanted."""

    moves: tuple[int, ...]
    """Axes along which vehicles may move off their paths: 0 1 2 for x y z."""
    slope_max: float
    """Slopes are cut to +- this [1/s^2]."""


def predict_drafts(model: InteractionModel, tracks: Tracks, rule: SlopeRule) -> DraftHorizon:
    """Return drafts and slopes along the horizon."""
    path = tracks.pos[tracks.first :]  # (N + 1, n, 3)
    middle = 0.5 * (path[1:] + path[:-1])
    i, j = _near_pairs(model.reach, middle)
    if i.size == 0:
        return no_drafts(tracks)
    here = np.swapaxes(middle, 0, 1)  # (n, N, 3)
    rel = _retarded(model, tracks, here, (i, j))
    step = np.diff(tracks.times[tracks.first :])
    vel = np.swapaxes(np.diff(path, axis=0) / step[:, None, None], 0, 1)
    motion = PairMotion(source_vel=vel[j], source_axis=tracks.axis[j], vel=vel[i])
    law, slope = _law_and_slope(model, rel, motion, rule.moves)
    strong = np.abs(law).max(axis=(1, 2)) > FAINT
    if not strong.all():
        i, j, law, slope = i[strong], j[strong], law[strong], slope[strong]
    count = tracks.trust[:, None] if tracks.strength is None else tracks.trust[:, None] * tracks.strength
    if not (count == 1.0).all():
        law, slope = law * count[j][..., None], slope * count[j][..., None, None]
    eta = np.zeros(here.shape)
    np.add.at(eta, i, law)
    return DraftHorizon(eta, i, j, np.clip(slope, -rule.slope_max, rule.slope_max))


def no_drafts(tracks: Tracks) -> DraftHorizon:
    """Return what a controller that ignores drafts predicts."""
    none = np.zeros(0, np.intp)
    n, stages = tracks.axis.shape[:2]
    return DraftHorizon(np.zeros((n, stages, 3)), none, none, np.zeros((0, stages, 3, 3)))


def _near_pairs(reach: Reach, middle: Array) -> tuple[Rows, Rows]:
    """Return the ordered pairs that come within reach at some stage of `middle` (N, n, 3)."""
    n = middle.shape[1]
    if reach.horizontal <= 0.0 or n < 2:
        return np.zeros(0, np.intp), np.zeros(0, np.intp)
    if n <= ALL_PAIRS:
        i, j = np.nonzero(~np.eye(n, dtype=np.bool_))
    else:
        low, high = middle.min(axis=0), middle.max(axis=0)  # (n, 3)
        half = 0.5 * (high - low).max(axis=0)
        wide = Reach(
            reach.horizontal + 2.0 * float(np.hypot(half[0], half[1])), reach.vertical + 2.0 * float(half[2])
        )
        i, j = pairs_in_reach(0.5 * (low + high), wide)
    rel = middle[:, j] - middle[:, i]  # (N, pairs, 3)
    across2 = rel[..., 0] ** 2 + rel[..., 1] ** 2
    near = (across2 <= reach.horizontal**2) & (np.abs(rel[..., 2]) <= reach.vertical)
    hit = near.any(axis=0)
    return i[hit], j[hit]


def _retarded(model: InteractionModel, tracks: Tracks, here: Array, pairs: tuple[Rows, Rows]) -> Array:
    """Return rel_pos (pairs, N, 3) with the sources where their push left them."""
    i, j = pairs
    rel = here[j] - here[i]
    if model.max_delay == 0.0:
        return rel
    stages = tracks.times[tracks.first :]
    when = 0.5 * (stages[1:] + stages[:-1]) - model.delay(rel)  # (pairs, N)
    after = np.clip(np.searchsorted(tracks.times, when), 1, tracks.times.size - 1)
    before = after - 1
    share = (when - tracks.times[before]) / (tracks.times[after] - tracks.times[before])
    share = np.clip(share, 0.0, 1.0)[..., None]
    rows = j[:, None]
    source = (1.0 - share) * tracks.pos[before, rows] + share * tracks.pos[after, rows]
    return np.asarray(source - here[i])


def _law_and_slope(
    model: InteractionModel, rel: Array, motion: PairMotion, moves: tuple[int, ...]
) -> tuple[Array, Array]:
    """Return the law (pairs, N, 3) and its slope (pairs, N, 3, 3), 0 where it is not wanted."""
    places = np.empty((1 + 2 * len(moves), *rel.shape))
    places[:] = rel
    for k, axis in enumerate(moves):
        places[1 + 2 * k, ..., axis] += DELTA
        places[2 + 2 * k, ..., axis] -= DELTA
    parts = (motion.source_vel, motion.source_axis, motion.vel)
    same = PairMotion(*(np.broadcast_to(part, places.shape) for part in parts))
    law = model.acceleration(places, same)
    slope = np.zeros((*rel.shape, 3))
    for k, axis in enumerate(moves):
        slope[..., axis] = (law[1 + 2 * k] - law[2 + 2 * k]) / (2.0 * DELTA)
    return law[0], slope
