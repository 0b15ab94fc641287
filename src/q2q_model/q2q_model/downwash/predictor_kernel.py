"""Kernels of the predictor: the search for pairs in reach, and the sum over sources.

| name | meaning [unit] |
|---|---|
| states | pos, vel [m, m/s], quat x y z w of every vehicle, (n, 10) |
| now | pos, vel, body z of every vehicle, (n, 9) |
| i, j | rows of every pair in reach, vehicle i exposed to source j, (p,) each |
"""

import math
from typing import NamedTuple

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.downwash.jet_kernel import JetPairs, evaluate_pairs, law_of_numbers
from q2q_model.downwash.sweep_and_prune import OrderedPairs, sweep
from q2q_model.signals.values import Array, InterferenceStatus, Mask, Status, TrackStatus

_VALID, _NO_MODEL = int(InterferenceStatus.VALID), int(InterferenceStatus.NO_MODEL)
_TRACKED, _STALE_SOURCE = int(TrackStatus.TRACKED), int(InterferenceStatus.STALE_SOURCE)


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
    """Write `now` and return the pairs, for horizontal and vertical reach [m] and largest delay [s]."""
    horizontal, vertical, max_delay = bounds
    pos, fastest = np.empty((states.shape[0], 3)), 0.0
    for i in range(states.shape[0]):
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
    pairs: OrderedPairs, outputs: PairInteractions, states: Array, known: bool, sums: InteractionSums
) -> None:
    """Write the sums; `known` is whether there is a model."""
    (feels, _), (eta, deviation, stale) = pairs, outputs
    acc, std, status = sums
    n = states.shape[0]
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
            whole = whole and math.isfinite(states[i, k])
        for k in range(3):
            std[i, k] = math.sqrt(std[i, k]) if whole else math.nan
        if not whole:
            status[i] = _NO_MODEL


@compiled
def write_present(
    states: Array,
    track: Status,
    bounds: tuple[float, float, float],
    law: Array,
    sums: PlainSums,
) -> None:
    """Write the sums over all sources of a jet that needs no past.

    It takes one call in place of three: for two vehicles a third of the time.

    Args:
        states: as above.
        track: TrackStatus, (n,).
        bounds: horizontal and vertical reach [m], largest delay [s].
        law: numbers of the JetLaw of one pair, (12,).
        sums: written.
    """
    now = np.empty((len(states), 9))
    found = find_pairs(states, now, bounds)
    feels, causes = found
    shape, stale = (feels.size, 3), np.empty(feels.size, np.bool_)
    pairs = JetPairs(np.empty(shape), np.empty(shape), np.empty(shape), np.empty(shape))
    for p in range(feels.size):
        i, j = feels[p], causes[p]
        stale[p] = track[j] != _TRACKED
        for k in range(3):
            pairs.rel_pos[p, k] = now[j, k] - now[i, k]
            pairs.source_vel[p, k], pairs.source_axis[p, k] = now[j, 3 + k], now[j, 6 + k]
            pairs.vel[p, k] = now[i, 3 + k]
    eta = np.empty(shape)
    evaluate_pairs(pairs, law_of_numbers(law), np.empty(feels.size), eta)
    outputs = PairInteractions(eta, np.full(shape, np.nan), stale)
    sum_over_sources(found, outputs, states, bounds[0] > 0.0, InteractionSums(*sums))
