"""Broad phase: the pairs that can affect each other in a tick, by a sweep over sorted x.

A pair is kept if the two might not stop apart (their stopping distances, with all growth, overlap), or if
the barrier might push: the required n.(a_i - a_j) is above what accelerations can be. Only rows whose x
differ by less than the largest reach are compared, so at bounded density the cost grows as n log n.
"""

from typing import NamedTuple

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array, Rows


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
    d: float
    reach: float
    """Largest distance at which a pair can matter [m]."""
    pole: float
    """Pole of the approach [1/s]."""
    push: float
    """Largest push of a pair [m/s^2]."""


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
    stopping_distances, growth = room.stopping_distances, room.growth
    first, second = np.empty(4 * len(order), np.intp), np.empty(4 * len(order), np.intp)
    count = 0
    for a in range(len(order)):
        for b in range(a + 1, len(order)):
            i, j = min(order[a], order[b]), max(order[a], order[b])
            x = pos[i, 0] - pos[j, 0]
            if not abs(x) <= limits.reach:  # also ends at NaN
                break
            y, z = pos[i, 1] - pos[j, 1], pos[i, 2] - pos[j, 2]
            if i >= limits.own or not abs(y) <= limits.reach or not abs(z) <= limits.reach + limits.d:
                continue
            across = np.sqrt(x * x + y * y)
            side, cap = across - limits.eps, abs(z) - limits.d
            h = max(side, cap) - growth[i, 0] - growth[j, 0]
            u, v, w = vel[i, 0] - vel[j, 0], vel[i, 1] - vel[j, 1], vel[i, 2] - vel[j, 2]
            closing = abs(w) if cap > 0.0 else 0.0
            closing += max(0.0, -(x * u + y * v) / across) if side > 0.0 else 0.0
            closing += growth[i, 1] + growth[j, 1]
            if (
                h > stopping_distances[i] + stopping_distances[j]
                and 2.0 * limits.pole * closing + limits.push < limits.pole * limits.pole * h
            ):
                continue
            if count == first.size:
                first, second = np.concatenate((first, first)), np.concatenate((second, second))
            first[count], second[count] = i, j
            count += 1
    return Pairs(first[:count], second[:count])
