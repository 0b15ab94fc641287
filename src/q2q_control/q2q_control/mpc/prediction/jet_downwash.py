"""Downwash of jets along the horizon, pair by pair in one compiled loop.

It computes what q2q_control.mpc.prediction.downwash_horizon does for any model, in the same order, but keeps
the places of one pair at a time and evaluates the displaced ones of a pair only if its downwash counts. A
test compares both, bit for bit.
"""

from typing import NamedTuple

import numpy as np

from q2q_control.mpc.prediction.downwash_horizon_kernel import (
    DELTA,
    PlainTracks,
    Tracks,
    add_pair,
    is_strong,
    may_reach,
)
from q2q_control.mpc.problem.horizon import DownwashHorizon, PlainDownwash
from q2q_model.compiled import BORROWING, compiled
from q2q_model.downwash.jet_kernel import JetLaw, JetPairs, evaluate_pairs, law_of_numbers
from q2q_model.downwash.sweep_and_prune import OrderedPairs
from q2q_model.geometry.pair_reach import is_beyond_reach
from q2q_model.signals.values import Array, Mask, Rows


class JetRule(NamedTuple):
    """Law of the jets, and the gradients that are evaluated."""

    numbers: Array
    """Those of the JetLaw, (12,)."""
    moves: Rows
    slope_max: float
    reach: tuple[float, float]
    """Horizontal and vertical [m]."""


PlainRule = tuple[Array, Rows, float, tuple[float, float]]
"""Fields of a JetRule, which numba takes from Python in less than half the time."""


@compiled
def sum_near_jets(jets: PlainRule, swarm: PlainTracks, pairs: OrderedPairs, way: Array) -> PlainDownwash:
    """Return the downwash (DownwashHorizon) of those of `pairs` that come within reach and are not faint.

    `way` (n, 2) is that of `way_in_delay`.
    """
    rule, tracks = JetRule(*jets), Tracks(*swarm)
    n, stages = tracks.axis.shape[0], tracks.axis.shape[1]
    near = may_reach(tracks.pos[tracks.first :], pairs, rule.reach, way)
    i, j = pairs[0][near], pairs[1][near]
    out = DownwashHorizon(np.zeros((n, stages, 3)), i, j, np.zeros((i.size, stages, 3, 3)))
    strong = _sum_jets(rule, tracks, out)
    if strong.all():
        return out.eta, i, j, out.gradient
    return out.eta, i[strong], j[strong], out.gradient[strong]


@compiled
def _sum_jets(rule: JetRule, tracks: Tracks, out: DownwashHorizon) -> Mask:
    """Add the downwash of pairs to `out.eta` and write their gradients; return those not faint."""
    law = law_of_numbers(rule.numbers)
    stages, count = tracks.axis.shape[1], 1 + 2 * rule.moves.size
    strong = np.zeros(out.i.size, np.bool_)
    places, eta, push = np.empty((count, stages, 3)), np.empty((count, stages, 3)), np.empty(count * stages)
    motion, ended = np.empty((4, stages, 3)), np.empty(stages, np.bool_)
    for p in range(out.i.size):
        _write_places(law, tracks, (out.i[p], out.j[p]), places[0], motion)
        for k in range(stages):
            ended[k] = is_beyond_reach(places[0, k], motion[3, k], rule.reach)
        if ended.all():
            continue
        _evaluate(law, places[:1], motion, push[:stages], eta[:1])
        _end(eta[:1], ended)
        strong[p] = is_strong(eta[0])
        if strong[p]:
            _displace(places, rule.moves)
            _evaluate(law, places[1:], motion, push[stages:], eta[1:])
            _end(eta[1:], ended)
            add_pair(eta, tracks.weight, (rule.moves, rule.slope_max), p, out)
    return strong


@compiled
def _evaluate(law: JetLaw, places: Array, motion: Array, push: Array, eta: Array) -> None:
    """Write the downwash at places (m, N, 3); `push` (m N,) is not used further."""
    pairs = JetPairs(places.reshape(-1, 3), motion[0], motion[1], motion[2])
    evaluate_pairs(pairs, law, push, eta.reshape(-1, 3))


@compiled(**BORROWING)
def _end(eta: Array, ended: Mask) -> None:
    """Set the downwash (m, N, 3) to none at the stages beyond the reach, (N,), at displaced places too.

    The end of a law is no slope of it.
    """
    for k in range(ended.size):
        if ended[k]:
            for m in range(eta.shape[0]):
                for axis in range(3):
                    eta[m, k, axis] = 0.0


@compiled(**BORROWING)
def _displace(places: Array, moves: Rows) -> None:
    """Write the first places (N, 3) moved by +DELTA and by -DELTA along each axis, as `displaced_places`."""
    for a in range(moves.size):
        for k in range(places.shape[1]):
            for axis in range(3):
                side = DELTA if axis == moves[a] else 0.0
                places[1 + 2 * a, k, axis] = places[0, k, axis] + side
                places[2 + 2 * a, k, axis] = places[0, k, axis] - side


@compiled(**BORROWING)
def _write_places(law: JetLaw, tracks: Tracks, pair: tuple[int, int], places: Array, motion: Array) -> None:
    """Write where the source is from the one who feels it, (N, 3), and how both move, (4, N, 3).

    The motion is that of JetPairs: velocity and axis of the source, velocity of the one who feels it; then
    the place of the source without the delay.
    """
    i, j = pair
    times, pos, first = tracks.times, tracks.pos, tracks.first
    after = 1
    for k in range(places.shape[0]):
        now, then = first + k, first + k + 1
        long, delay = times[then] - times[now], 0.0
        for axis in range(3):
            here = 0.5 * (pos[then, i, axis] + pos[now, i, axis])
            places[k, axis] = 0.5 * (pos[then, j, axis] + pos[now, j, axis]) - here
            motion[0, k, axis] = (pos[then, j, axis] - pos[now, j, axis]) / long
            motion[1, k, axis] = tracks.axis[j, k, axis]
            motion[2, k, axis] = (pos[then, i, axis] - pos[now, i, axis]) / long
            motion[3, k, axis] = places[k, axis]
        if law.travel_speed == 0.0:
            continue
        delay = min(max(places[k, 2], 0.0), law.range) / law.travel_speed
        when = 0.5 * (times[then] + times[now]) - delay
        after = _entry_after(times, when, after)
        share = (when - times[after - 1]) / (times[after] - times[after - 1])
        share = min(max(share, 0.0), 1.0)
        for axis in range(3):
            here = 0.5 * (pos[then, i, axis] + pos[now, i, axis])
            source = (1.0 - share) * pos[after - 1, j, axis] + share * pos[after, j, axis]
            places[k, axis] = source - here


@compiled(**BORROWING)
def _entry_after(times: Array, when: float, near: int) -> int:
    """Return the first entry at or after a time, at least 1 and at most the last; `near` is a first guess."""
    after = near
    while after < times.size - 1 and times[after] < when:
        after += 1
    while after > 1 and times[after - 1] >= when:
        after -= 1
    return after
