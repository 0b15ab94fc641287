"""Kernels of the predictor: the search for pairs in reach, and the sum over sources.

| name | meaning [unit] |
|---|---|
| states | pos, vel [m, m/s], quat x y z w, age [s] of every vehicle, (n, 11) |
| now | pos, vel, body z of every vehicle, (n, 9) |
| i, j | rows of every pair in reach, vehicle i exposed to source j, (p,) each |
"""

import math
from typing import NamedTuple

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.downwash.jet_kernel import JetLaw, JetPairs, evaluate_pairs, law_of_numbers
from q2q_model.downwash.state_history import states_at
from q2q_model.downwash.sweep_and_prune import OrderedPairs, sweep
from q2q_model.signals.values import Array, InterferenceStatus, Mask, Status, TrackStatus

_VALID, _NO_MODEL = int(InterferenceStatus.VALID), int(InterferenceStatus.NO_MODEL)
_TRACKED, _STALE_SOURCE = int(TrackStatus.TRACKED), int(InterferenceStatus.STALE_SOURCE)
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
PlainJet = tuple[Array, tuple[float, float]]
"""Numbers of a JetLaw, (12,); growth of the standard deviation with the downwash, and its floor [m/s^2]."""


@compiled
def body_z(state: Array, axis: Array) -> None:
    """Write the body z axis of one vehicle; level where its orientation is unknown."""
    x, y, z, w = state[6], state[7], state[8], state[9]
    axis[0], axis[1] = 2.0 * (x * z + w * y), 2.0 * (y * z - w * x)
    axis[2] = 1.0 - 2.0 * (x * x + y * y)
    for k in range(3):
        if not math.isfinite(axis[k]):
            axis[k] = 1.0 if k == 2 else 0.0


@compiled
def find_pairs(states: Array, now: Array, bounds: tuple[float, float, float]) -> OrderedPairs:
    """Write `now` and return the pairs, for horizontal and vertical reach [m] and largest delay [s].

    The state of a vehicle that was never seen, of infinite age, is made NaN.
    """
    horizontal, vertical, max_delay = bounds
    pos, fastest = np.empty((states.shape[0], 3)), 0.0
    for i in range(states.shape[0]):
        if math.isinf(states[i, _AGE]):
            states[i] = math.nan
        whole, squared = True, 0.0
        for k in range(6):
            now[i, k] = states[i, k]
            whole = whole and math.isfinite(states[i, k])
        for k in range(3):
            pos[i, k] = states[i, k] if whole else math.nan
            squared += states[i, 3 + k] * states[i, 3 + k]
        if whole:
            fastest = max(fastest, squared)
        body_z(states[i], now[i, 6:])
    moved = max_delay * math.sqrt(fastest)  # distance a source may have moved since its air left it
    return sweep(pos, horizontal + moved, vertical + moved)


@compiled
def sum_over_sources(
    pairs: OrderedPairs, outputs: PairInteractions, now: Array, known: bool, sums: InteractionSums
) -> None:
    """Write the sums; `known` is whether there is a model."""
    (feels, _), (eta, deviation, stale) = pairs, outputs
    acc, std, status = sums
    n = now.shape[0]
    acc[:], std[:], status[:] = 0.0, 0.0, _VALID
    for p in range(feels.size):
        i = feels[p]
        for k in range(3):
            acc[i, k] += eta[p, k]
            std[i, k] += deviation[p, k] * deviation[p, k]
        if stale[p]:
            status[i] = _STALE_SOURCE
    for i in range(n):
        whole = known
        for k in range(6):
            whole = whole and math.isfinite(now[i, k])
        for k in range(3):
            std[i, k] = math.sqrt(std[i, k]) if whole else math.nan
        if not whole:
            status[i] = _NO_MODEL


@compiled
def write_present(
    states: Array, track: Status, bounds: tuple[float, float, float], jet: PlainJet, sums: PlainSums
) -> None:
    """Write the sums over all sources of a jet that needs no past.

    It takes one call in place of three: for two vehicles a third of the time.

    Args:
        states: as above.
        track: TrackStatus, (n,).
        bounds: horizontal and vertical reach [m], largest delay [s].
        jet: law and deviation of one pair.
        sums: written.
    """
    now = np.empty((len(states), 9))
    pairs = find_pairs(states, now, bounds)
    causes = pairs[1]
    sources, stale = np.empty((causes.size, 9)), np.empty(causes.size, np.bool_)
    for p in range(causes.size):
        sources[p], stale[p] = now[causes[p]], track[causes[p]] != _TRACKED
    _sum_jets(pairs, now, (sources, stale), jet, InteractionSums(*sums))


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
        jet: law and deviation of one pair.
        sums: written.
    """
    tick = PresentTick(*present)
    sources = _retarded(pairs, tick, past, law_of_numbers(jet[0]))
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
        stale[p] = not known or tick.track[causes[p]] != _TRACKED
    return sources, stale


@compiled
def _sum_jets(
    pairs: OrderedPairs, now: Array, sources: tuple[Array, Mask], jet: PlainJet, sums: InteractionSums
) -> None:
    """Write the sums over the jets of `sources`: pos, vel, body z, (p, 9), and which are stale, (p,)."""
    (feels, _), (states, stale), (relative_std, floor) = pairs, sources, jet[1]
    shape, known = (feels.size, 3), relative_std + floor > 0.0
    moving = JetPairs(np.empty(shape), np.empty(shape), np.empty(shape), np.empty(shape))
    for p in range(feels.size):
        for k in range(3):
            moving.rel_pos[p, k] = states[p, k] - now[feels[p], k]
            moving.source_vel[p, k], moving.source_axis[p, k] = states[p, 3 + k], states[p, 6 + k]
            moving.vel[p, k] = now[feels[p], 3 + k]
    eta, deviation = np.empty(shape), np.full(shape, np.nan)
    evaluate_pairs(moving, law_of_numbers(jet[0]), np.empty(feels.size), eta)
    for p in range(feels.size):
        if known:
            deviation[p, 2] = floor + relative_std * abs(eta[p, 2])
    sum_over_sources(pairs, PairInteractions(eta, deviation, stale), now, known=True, sums=sums)
