"""Kernels of the predictor: the search for pairs, and the sum over sources.

| name | meaning [unit] |
|---|---|
| states | pos, vel [m, m/s], world, quat x y z w, body to world, age [s] of every vehicle, (n, 11) |
| now | pos, vel [m, m/s], body z of every vehicle, world, (n, 9) |
| i, j | rows of every pair found, vehicle i exposed to source j, (p,) each |
"""

import math
from typing import NamedTuple

import numpy as np

from q2q_model.compiled import BORROWING, compiled
from q2q_model.downwash.jet_kernel import JetLaw, JetPairs, evaluate_pairs, law_of_numbers
from q2q_model.downwash.state_history import states_at
from q2q_model.downwash.sweep_and_prune import OrderedPairs, sweep
from q2q_model.geometry.pair_reach import SLACK, is_beyond_reach
from q2q_model.signals.values import NO_MODEL, STALE_SOURCE, TRACKED, VALID, Array, Mask, Rows, Status

_AGE = 10
"""Column of states."""


class PairInteractions(NamedTuple):
    """Answers of a model to the pairs of a tick."""

    eta: Array
    """[m/s^2], (p, 3)."""
    deviation: Array
    """[m/s^2], (p, 3)."""
    stale: Mask
    """Source not tracked, (p,)."""
    ended: Mask
    """Beyond the reach, (p,): no downwash, whatever the others say."""


class InteractionSums(NamedTuple):
    """Sums over the sources of each vehicle."""

    acc: Array
    """[m/s^2], (n, 3)."""
    std: Array
    """[m/s^2], (n, 3)."""
    status: Status
    """InterferenceStatus, (n,)."""


PlainSums = tuple[Array, Array, Status]
"""Fields of InteractionSums, which numba takes in a third of the time."""


class PresentTick(NamedTuple):
    """Swarm at a tick."""

    t: float
    """[s]"""
    now: Array
    track: Status
    """TrackStatus, (n,)."""


PlainTick = tuple[float, Array, Status]
"""Fields of a PresentTick."""


class JetSources(NamedTuple):
    """Sources of pairs, as they were when their air left them."""

    states: Array
    """pos, vel, body z, (k, 9)."""
    rows: Rows
    """Row of each pair's source in them, (p,)."""
    stale: Mask
    """(p,)."""


PlainJet = tuple[Array, tuple[float, float, float, float]]
"""Numbers of a JetLaw, (12,); growth of the standard deviation with the downwash, and its floor [m/s^2], then
the horizontal and the vertical reach [m]."""


@compiled
def write_body_z(state: Array, axis: Array) -> None:
    """Write body z, world, (3,) of a `state`, a row of `states`; level where its orientation is unknown."""
    x, y, z, w = state[6], state[7], state[8], state[9]
    axis[0], axis[1] = 2.0 * (x * z + w * y), 2.0 * (y * z - w * x)
    axis[2] = 1.0 - 2.0 * (x * x + y * y)
    if not (math.isfinite(axis[0]) and math.isfinite(axis[1]) and math.isfinite(axis[2])):
        axis[0], axis[1], axis[2] = 0.0, 0.0, 1.0


@compiled
def find_pairs(states: Array, now: Array, past: Array, reach: tuple[float, float]) -> OrderedPairs:
    """Write `now` and return all pairs that may have downwash, and some that are beyond the reach.

    The state of a vehicle that was never seen, of infinite age, is made NaN.

    Args:
        states: as above.
        now: written.
        past: rows of `now` when air may have left its source, (K, n, 9); K = 0 for a law without delay.
        reach: horizontal and vertical [m].
    """
    pos = np.empty((states.shape[0], 3))
    for i in range(states.shape[0]):
        if math.isinf(states[i, _AGE]):
            states[i] = math.nan
        whole = True
        for k in range(6):
            now[i, k] = states[i, k]
            whole = whole and math.isfinite(states[i, k])
        for k in range(3):
            pos[i, k] = states[i, k] if whole else math.nan
        write_body_z(states[i], now[i, 6:])
    if past.size == 0:  # no delay, or no vehicle
        return sweep(pos, reach[0], reach[1])
    far = np.zeros((pos.shape[0], 2))
    _write_moved(pos, past, far)
    for v in range(pos.shape[0]):
        far[v, 0], far[v, 1] = reach[0] + math.sqrt(far[v, 0]) + SLACK, reach[1] + far[v, 1] + SLACK
    return _near_enough(sweep(pos, far[:, 0].max(), far[:, 1].max()), pos, far)


@compiled(**BORROWING)
def _write_moved(pos: Array, past: Array, moved: Array) -> None:
    """Write how far each vehicle has moved at most: horizontally, squared [m^2], and vertically [m], (n, 2).

    Positions in between are interpolated, and no farther. NaN is no distance.
    """
    for k in range(past.shape[0]):
        for v in range(pos.shape[0]):
            x, y = past[k, v, 0] - pos[v, 0], past[k, v, 1] - pos[v, 1]
            squared, rise = x * x + y * y, abs(past[k, v, 2] - pos[v, 2])
            moved[v, 0] = max(moved[v, 0], squared)
            moved[v, 1] = max(moved[v, 1], rise)


@compiled
def _near_enough(pairs: OrderedPairs, pos: Array, far: Array) -> OrderedPairs:
    """Return the pairs within what their sources reach, horizontally and vertically [m], (n, 2)."""
    i, j = pairs
    kept = 0
    for p in range(i.size):
        a, b = i[p], j[p]
        x, y, dz = pos[b, 0] - pos[a, 0], pos[b, 1] - pos[a, 1], pos[b, 2] - pos[a, 2]
        if x * x + y * y <= far[b, 0] * far[b, 0] and abs(dz) <= far[b, 1]:
            i[kept], j[kept] = a, b
            kept += 1
    return i[:kept], j[:kept]


@compiled
def sum_over_sources(
    pairs: OrderedPairs, outputs: PairInteractions, now: Array, known: bool, sums: InteractionSums
) -> None:
    """Write the sums.

    Args:
        pairs: (p,) each.
        outputs: of the pairs.
        now: as above.
        known: whether there is a model.
        sums: of the vehicles.
    """
    (feels, _), (eta, deviation, stale, ended) = pairs, outputs
    acc, std, status = sums
    n = now.shape[0]
    acc[:], std[:], status[:] = 0.0, 0.0, VALID
    for p in range(feels.size):
        if ended[p]:
            continue
        i = feels[p]
        for k in range(3):
            acc[i, k] += eta[p, k]
            std[i, k] += deviation[p, k] * deviation[p, k]
        if stale[p]:
            status[i] = STALE_SOURCE
    for i in range(n):
        whole = known
        for k in range(6):
            whole = whole and math.isfinite(now[i, k])
        for k in range(3):
            std[i, k] = math.sqrt(std[i, k]) if whole else math.nan
        if not whole:
            status[i] = NO_MODEL


@compiled
def write_present(states: Array, track: Status, jet: PlainJet, sums: PlainSums) -> None:
    """Write the sums over all sources of a jet that needs no past.

    It takes one call in place of three: for two vehicles a third of the time.

    Args:
        states: as above.
        track: TrackStatus, (n,).
        jet: law, deviation and reach of one pair.
        sums: written.
    """
    now = np.empty((len(states), 9))
    pairs = find_pairs(states, now, np.empty((0, len(states), 9)), jet[1][2:])
    causes = pairs[1]
    stale = np.empty(causes.size, np.bool_)
    for p in range(causes.size):
        stale[p] = track[causes[p]] != TRACKED
    _sum_jets(pairs, now, JetSources(now, causes, stale), jet, InteractionSums(*sums))


@compiled
def write_retarded(
    pairs: OrderedPairs, present: PlainTick, past: tuple[Array, Array], jet: PlainJet, sums: PlainSums
) -> None:
    """Write the sums over all sources of a jet, each as it was when its air left it.

    It computes what `retarded_pairs`, `Jet` and `sum_over_sources` do: for two vehicles in a fifth of the
    time.

    Args:
        pairs: i and j.
        present: swarm now.
        past: stamps (K,) [s] and `now` at each, (K, n, 9).
        jet: law, deviation and reach of one pair.
        sums: written.
    """
    tick = PresentTick(*present)
    states, stale = _retarded(pairs, tick, past, law_of_numbers(jet[0]))
    sources = JetSources(states, np.arange(stale.size), stale)
    _sum_jets(pairs, tick.now, sources, jet, InteractionSums(*sums))


@compiled
def _retarded(
    pairs: OrderedPairs, tick: PresentTick, past: tuple[Array, Array], law: JetLaw
) -> tuple[Array, Mask]:
    """Return the sources as they were when their air left them, (p, 9), and which are stale, (p,).

    A source whose state was not known then is as it is now, and stale.
    """
    (feels, causes), now = pairs, tick.now
    left, stale = np.empty(causes.size), np.empty(causes.size, np.bool_)
    for p in range(causes.size):
        above = now[causes[p], 2] - now[feels[p], 2]
        left[p] = tick.t - min(max(above, 0.0), law.range) / law.travel_speed
    sources = states_at(past[0], past[1], left, causes)
    for p in range(causes.size):
        known = True
        for k in range(6):
            known = known and math.isfinite(sources[p, k])
        if not known:
            sources[p] = now[causes[p]]
        stale[p] = not known or tick.track[causes[p]] != TRACKED
    return sources, stale


@compiled
def _sum_jets(
    pairs: OrderedPairs, now: Array, sources: JetSources, jet: PlainJet, sums: InteractionSums
) -> None:
    """Write the sums over the jets of the sources."""
    (feels, causes), (states, rows, stale), (relative_std, floor, aside, up) = pairs, sources, jet[1]
    shape, known = (feels.size, 3), relative_std + floor > 0.0
    moving = JetPairs(np.empty(shape), np.empty(shape), np.empty(shape), np.empty(shape))
    for p in range(feels.size):
        i, j = feels[p], rows[p]
        for k in range(3):
            moving.rel_pos[p, k] = states[j, k] - now[i, k]
            moving.source_vel[p, k], moving.source_axis[p, k] = states[j, 3 + k], states[j, 6 + k]
            moving.vel[p, k] = now[i, 3 + k]
    eta, deviation, ended = np.empty(shape), np.full(shape, np.nan), np.empty(feels.size, np.bool_)
    evaluate_pairs(moving, law_of_numbers(jet[0]), np.empty(feels.size), eta)
    offset = np.empty(3)
    for p in range(feels.size):
        for k in range(3):
            offset[k] = now[causes[p], k] - now[feels[p], k]
        ended[p] = is_beyond_reach(moving.rel_pos[p], offset, (aside, up))
        if known:
            deviation[p, 2] = floor + relative_std * abs(eta[p, 2])
    sum_over_sources(pairs, PairInteractions(eta, deviation, stale, ended), now, known=True, sums=sums)
