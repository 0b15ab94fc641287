"""Prediction of the downwash along the horizon, and of its gradients as vehicles leave their last prediction.

The downwash of stage k is taken at its middle, where each vehicle is half-way between two stages of its last
predicted path. The source's position is that of a delay tau earlier: in the past, or on its predicted path.

    rel_k = r_j(t_k - tau) - r_i(t_k)
    eta_i,k = sum_j s_j,k law(rel_k),  G_ij,k = s_j,k d law / d rel at rel_k

The jet of a source points against its predicted thrust and is s_j,k times as strong as when hovering: a
source that is itself pushed down carries its weight and its downwash. Vehicles in between absorb part of it
if the model says so (q2q_model.downwash.source_strength). G is found by central differences and
neglects the delay of the source's displacement. The delay is exact in eta itself, so nothing is lost as long
as the path is the predicted one.

| symbol | name | meaning [unit] |
|---|---|---|
| i, j | i, j | vehicle that feels, vehicle that causes |
| eta | eta | downwash acceleration [m/s^2], world, (n, N, 3) |
| G | gradient | [1/s^2], (pairs, N, 3, 3): row feels, column moves |
| s | weight | of a source's downwash [-], (n, N) |
| sigma | spread | uncertainty of a source's horizontal position, which widens its downwash [m], (n,) |
"""

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from q2q_control.mpc.prediction.downwash_horizon_kernel import (
    Tracks,
    bounding_boxes,
    displaced_places,
    may_reach,
    sum_downwash,
    way_in_delay,
)
from q2q_control.mpc.prediction.jet_downwash import JetRule, PlainRule, sum_near_jets
from q2q_control.mpc.problem.horizon import DownwashHorizon
from q2q_model.downwash.interaction_model import (
    InteractionModel,
    Reach,
    RetardedPairs,
    SourceStates,
    downwash_ended,
    retarded_pairs,
)
from q2q_model.downwash.jet import Jet, jet_law
from q2q_model.downwash.source_strength import SourceTerms, source_terms, strengths
from q2q_model.downwash.state_history import states_at
from q2q_model.downwash.sweep_and_prune import OrderedPairs, pairs_in_reach
from q2q_model.signals.values import Array

ALL_PAIRS = 64
"""Up to this many pairs all are checked; above, a sweep over sorted x finds candidates."""
KNOWN_MODELS = 8
"""Models whose numbers for the compiled loop are remembered."""

GAUSS_HERMITE = ((-math.sqrt(3.0), 1.0 / 6.0), (0.0, 2.0 / 3.0), (math.sqrt(3.0), 1.0 / 6.0))
"""Places [standard deviations] and weights of the mean over a normal distribution, exact to degree 5."""
NEGLIGIBLE_SPREAD = 0.01
"""Spread up to which a source counts as certain [m]: a jet of 0.1 m is 1 % weaker by it on its axis."""


@dataclass(frozen=True, slots=True)
class GradientRule:
    """Selection of the gradients that are evaluated."""

    moves: tuple[int, ...]
    """Axes along which vehicles may move off their paths: 0 1 2 for x y z."""
    slope_max: float
    """Gradients are clipped to +- this [1/s^2]."""


class Others(NamedTuple):
    """Vehicles of other controllers, which follow the controlled ones in the tracks."""

    own: int
    """Number of controlled vehicles."""
    spread: Array
    """Standard deviation of every vehicle's horizontal position, each axis [m], (n,)."""


def predict_downwash(
    model: InteractionModel, tracks: Tracks, rule: GradientRule, others: Others | None = None
) -> DownwashHorizon:
    """Return downwash and gradients along the horizon; with `others`, only what `own` vehicles feel."""
    n, absorption = len(tracks.axis), source_terms(model).absorption  # loading is in the tracks' weight
    spread = others.spread if others is not None else np.zeros(n)
    way = way_in_delay((*tracks,), model.max_delay, spread)
    felt = others.own if others is not None and not absorption else n
    pairs = _pairs_to_check(model.reach, tracks, felt, way)
    jets = _jet_rule(model, rule) if isinstance(model, Jet) and not absorption else None
    if others is None and jets is not None:
        return DownwashHorizon(*sum_near_jets(jets, (*tracks,), pairs, way))
    i, j = _near(model.reach, tracks, pairs, way)
    if i.size == 0:
        return no_downwash(tracks)
    widened = spread[j].max() > NEGLIGIBLE_SPREAD
    if jets is not None and not widened:
        return DownwashHorizon(*sum_near_jets(jets, (*tracks,), (i, j), way))
    law = _law_of(model, tracks, (i, j), rule, spread[j] if widened else None)
    if absorption:
        vertical = np.ascontiguousarray(law[0, ..., 2])
        terms = SourceTerms(absorption=absorption)
        law *= strengths(i, j, vertical, np.ones_like(vertical), terms)[..., None]
    return _summed(law, tracks, (i, j), rule)


@lru_cache(maxsize=KNOWN_MODELS)
def _jet_rule(model: Jet, rule: GradientRule) -> PlainRule:
    reach = model.reach.horizontal, model.reach.vertical
    return (*JetRule(np.array(jet_law(model)), np.array(rule.moves), rule.slope_max, reach),)


def _summed(law: Array, tracks: Tracks, pairs: OrderedPairs, rule: GradientRule) -> DownwashHorizon:
    """Return the downwash of pairs at all places, (1 + 2 moves, pairs, N, 3), without faint ones."""
    (i, j), (n, stages) = pairs, tracks.axis.shape[:2]
    downwash = DownwashHorizon(np.zeros((n, stages, 3)), i, j, np.zeros((i.size, stages, 3, 3)))
    strong = sum_downwash(law, tracks.weight, np.array(rule.moves), rule.slope_max, downwash)
    return DownwashHorizon(downwash.eta, i[strong], j[strong], downwash.gradient[strong])


def _law_of(
    model: InteractionModel, tracks: Tracks, pairs: OrderedPairs, rule: GradientRule, spread: Array | None
) -> Array:
    """Return the downwash of a model at all places [m/s^2], (1 + 2 moves, pairs, N, 3).

    `spread` (pairs,) is that of the sources; None if they are certain.
    """
    there = _pairs_along(model, tracks, pairs)
    places = displaced_places(there.rel_pos, np.array(rule.moves))
    if spread is None:
        return _ended_law(model, there, places)
    return _widened(model, there, places, spread)


def _ended_law(model: InteractionModel, pairs: RetardedPairs, places: Array) -> Array:
    """Return the law at places (..., 1 + 2 moves, pairs, N, 3), and none of a pair beyond the reach.

    The displaced places end with the pair's own, (..., pairs, N, 3): the end of a law is no slope of it.
    """
    ended = downwash_ended(pairs, model.reach)[..., None, :, :, None]
    return np.where(ended, 0.0, model.acceleration(places, pairs.motion))


def no_downwash(tracks: Tracks) -> DownwashHorizon:
    """Return zero downwash, as predicted by a controller that ignores it."""
    none = np.zeros(0, np.intp)
    n, stages = tracks.axis.shape[:2]
    return DownwashHorizon(np.zeros((n, stages, 3)), none, none, np.zeros((0, stages, 3, 3)))


def _pairs_to_check(reach: Reach, tracks: Tracks, felt: int, way: Array) -> OrderedPairs:
    """Return ordered pairs, among them all that come within reach; only the first `felt` vehicles feel."""
    n = len(tracks.axis)
    if reach.horizontal <= 0.0 or n < 2:
        return np.zeros(0, np.intp), np.zeros(0, np.intp)
    if felt * (n - 1) <= ALL_PAIRS:
        return _all_pairs(felt, n)
    centre, half = bounding_boxes(tracks.pos[tracks.first :])
    aside = reach.horizontal + 2.0 * float(np.hypot(half[0], half[1])) + float(way[:, 0].max())
    up = reach.vertical + 2.0 * float(half[2]) + float(way[:, 1].max())
    i, j = pairs_in_reach(centre, Reach(aside, up))
    return (i[i < felt], j[i < felt]) if felt < n else (i, j)


def _near(reach: Reach, tracks: Tracks, pairs: OrderedPairs, way: Array) -> OrderedPairs:
    """Return those of `pairs` that may come within reach at some stage."""
    hit = may_reach(tracks.pos[tracks.first :], pairs, (reach.horizontal, reach.vertical), way)
    return pairs[0][hit], pairs[1][hit]


@lru_cache(maxsize=ALL_PAIRS)
def _all_pairs(felt: int, n: int) -> OrderedPairs:
    i, j = np.nonzero(~np.eye(felt, n, dtype=np.bool_))
    return i.copy(), j.copy()  # columns of one array: one layout, one kernel


def _widened(model: InteractionModel, pairs: RetardedPairs, places: Array, spread: Array) -> Array:
    """Return the downwash expected of sources whose horizontal positions have a `spread` [m], (pairs,).

    The mean over a normal distribution of the source, by Gauss-Hermite quadrature of three points per axis.
    """
    points = np.array([(x, y, 0.0) for x, _ in GAUSS_HERMITE for y, _ in GAUSS_HERMITE])
    shares = [of_x * of_y for _, of_x in GAUSS_HERMITE for _, of_y in GAUSS_HERMITE]
    away = points[:, None, None] * spread[:, None, None]  # (points, pairs, 1, 3)
    moved = RetardedPairs(pairs.rel_pos + away, pairs.motion, pairs.now + away)
    return np.asarray(np.tensordot(shares, _ended_law(model, moved, places + away[:, None]), 1))


def _pairs_along(model: InteractionModel, tracks: Tracks, pairs: OrderedPairs) -> RetardedPairs:
    """Return the pairs at the middles of the stages, (pairs, N)."""
    i, j = pairs
    times = tracks.times[tracks.first :]
    path = tracks.pos[tracks.first :].transpose(1, 0, 2)  # (n, N + 1, 3)
    middle = 0.5 * (path[:, 1:] + path[:, :-1])
    vel = (path[:, 1:] - path[:, :-1]) / (times[1:] - times[:-1])[:, None]
    now = SourceStates(middle[j], vel[j], tracks.axis[j])

    def past(delay: Array) -> SourceStates:
        when = 0.5 * (times[1:] + times[:-1]) - delay  # (pairs, N)
        pos = states_at(tracks.times, tracks.pos, when.ravel(), np.repeat(j, times.size - 1))
        return replace(now, pos=pos.reshape(now.pos.shape))

    return retarded_pairs(model, middle[i], vel[i], now, past)
