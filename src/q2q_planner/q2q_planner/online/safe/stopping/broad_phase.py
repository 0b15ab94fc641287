"""Broad phase: the pairs that can affect each other in a tick, by a sweep over sorted x.

A pair is kept if the two might not stop apart (their stopping distances, with all growth, overlap), or if
the barrier might act: the required n.(a_i - a_j) is above what accelerations can be. Both need the distance
h to the zone and the speed h' at which it shrinks, so only pairs whose reaches overlap are looked at: a
vehicle's reach is its share of the largest h of a pair that is kept, in whatever direction both fly.

    left out if    h > D_i + D_j,  p^2 h > 2 p h' + a      D: stopping distance
    where          h' <= sqrt(2) (|v_i| + |v_j|) + g1_i + g1_j

A row's sweep ends where x differs by more than the reaches: at bounded density the cost grows as n log n.
"""

import math
from typing import NamedTuple

import numpy as np

from q2q_model.compiled import HOT, compiled
from q2q_model.signals.values import Array, Rows

BOTH_WAYS = math.sqrt(2.0)
"""Horizontal and vertical closing speed of a pair add up to at most this times its relative speed [-]."""
ROUNDING = 1.0 + 1e-9
"""By so much reaches are longer than they must be, against rounding [-]."""


class Pairs(NamedTuple):
    """Rows i < j of pairs."""

    i: Rows
    """Rows of the swarm, (pairs,)."""
    j: Rows
    """Rows of the swarm or of external vehicles, (pairs,)."""


class StoppingSpace(NamedTuple):
    """Space that each row may need."""

    stopping_distances: Array
    """Stopping distance with all growth [m], (rows,)."""
    growth: Array
    """g0 [m] and g1 [m/s], (rows, 2)."""


class SweepLimits(NamedTuple):
    """Limits of the sweep."""

    own: int
    """Rows of the swarm."""
    eps: float
    """Radius of the zone [m]."""
    d: float
    """Half height of the zone [m]."""
    pole: float
    """Pole p of the approach [1/s]."""
    correction: float
    """Largest correction a of a pair [m/s^2]."""


@compiled
def broad_phase(pos: Array, vel: Array, room: StoppingSpace, limits: SweepLimits) -> Pairs:
    """Return rows i < j, i of the swarm, of all pairs that can affect each other.

    Args:
        pos: [m], (rows, 3); a row with NaN is in no pair.
        vel: [m/s], (rows, 3).
        room: space that each row may need.
        limits: see SweepLimits.
    """
    order = np.argsort(pos[:, 0], kind="mergesort")  # NaN sorts last
    place, reach = pos[order], _reaches(vel, room, limits)[order]
    far = _largest(reach) + limits.eps
    first, second = np.empty(4 * len(order), np.intp), np.empty(4 * len(order), np.intp)
    count = 0
    for a in range(len(order)):
        for b in range(a + 1, len(order)):
            x, both = place[b, 0] - place[a, 0], reach[a] + reach[b]
            if not x <= reach[a] + far:  # also ends at NaN
                break
            y, z, across = place[b, 1] - place[a, 1], place[b, 2] - place[a, 2], limits.eps + both
            if not (x * x + y * y <= across * across and abs(z) <= limits.d + both):
                continue
            i, j = min(order[a], order[b]), max(order[a], order[b])
            if i >= limits.own or not _matters(pos, vel, (i, j), room, limits):
                continue
            if count == first.size:
                first, second = np.concatenate((first, first)), np.concatenate((second, second))
            first[count], second[count] = i, j
            count += 1
    return Pairs(first[:count], second[:count])


@compiled
def _reaches(vel: Array, room: StoppingSpace, limits: SweepLimits) -> Array:
    """Return each row's share of the largest distance from the zone of a pair that is kept [m], (rows,)."""
    reaches, growth = np.empty(len(vel)), room.growth
    for row in range(reaches.size):
        u, v, w = vel[row, 0], vel[row, 1], vel[row, 2]
        closing = BOTH_WAYS * np.sqrt(u * u + v * v + w * w) + growth[row, 1]
        braked = (2.0 * limits.pole * closing + 0.5 * limits.correction) / (limits.pole * limits.pole)
        reaches[row] = ROUNDING * (max(room.stopping_distances[row], braked) + growth[row, 0])
    return reaches


@compiled
def _largest(reaches: Array) -> float:
    largest = 0.0
    for reach in reaches:
        largest = max(largest, reach)  # not NaN
    return largest


@compiled(**HOT)
def _matters(pos: Array, vel: Array, pair: tuple[int, int], room: StoppingSpace, limits: SweepLimits) -> bool:
    """Return whether a pair might not stop apart, or be corrected."""
    (i, j), stopping_distances, growth = pair, room.stopping_distances, room.growth
    x, y, z = pos[i, 0] - pos[j, 0], pos[i, 1] - pos[j, 1], pos[i, 2] - pos[j, 2]
    across = np.sqrt(x * x + y * y)
    side, cap = across - limits.eps, abs(z) - limits.d
    h = max(side, cap) - growth[i, 0] - growth[j, 0]
    u, v, w = vel[i, 0] - vel[j, 0], vel[i, 1] - vel[j, 1], vel[i, 2] - vel[j, 2]
    closing = abs(w) if cap > 0.0 else 0.0
    closing += max(0.0, -(x * u + y * v) / across) if side > 0.0 else 0.0
    closing += growth[i, 1] + growth[j, 1]
    slow = 2.0 * limits.pole * closing + limits.correction < limits.pole * limits.pole * h
    return not (h > stopping_distances[i] + stopping_distances[j] and slow)
