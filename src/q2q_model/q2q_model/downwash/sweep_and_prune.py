"""Broad phase: all pairs within reach, by sweep and prune over x.

With vehicles sorted by x, the neighbours of a vehicle lie in the rows up to an x difference of the reach. At
bounded density the number of these rows does not grow with n, so sorting costs n log n and sweeping n; a
dense comparison costs n^2.
"""

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.downwash.interaction_model import Reach
from q2q_model.signals.values import Array, Rows

OrderedPairs = tuple[Rows, Rows]
"""Rows i and j of ordered pairs, (p,) each: i feels j."""


def pairs_in_reach(pos: Array, reach: Reach) -> OrderedPairs:
    """Return rows (i, j) of all ordered pairs within reach, sorted by i, then j.

    Contains both (i, j) and (j, i), i != j. A vehicle with a NaN coordinate is in no pair.

    Args:
        pos: positions [m], world, (n, 3).
        reach: largest horizontal and vertical distance of a pair.
    """
    return sweep(np.ascontiguousarray(pos), reach.horizontal, reach.vertical)


@compiled
def sweep(pos: Array, horizontal: float, vertical: float) -> OrderedPairs:
    """Return the pairs of pos (n, 3) within the reaches [m], as `pairs_in_reach`."""
    order = np.argsort(pos[:, 0])  # NaN sorts last
    place = pos[order]
    one, other = np.empty(4 * order.size, np.intp), np.empty(4 * order.size, np.intp)
    count = 0
    for a in range(order.size):
        for b in range(a + 1, order.size):
            dx = place[b, 0] - place[a, 0]
            if not dx <= horizontal:  # also ends at NaN
                break
            dy, dz = place[b, 1] - place[a, 1], place[b, 2] - place[a, 2]
            if dx * dx + dy * dy <= horizontal * horizontal and abs(dz) <= vertical:
                if count == one.size:
                    one, other = np.concatenate((one, one)), np.concatenate((other, other))
                one[count], other[count] = order[a], order[b]
                count += 1
    return _both_ways((one[:count], other[:count]), order.size)


@compiled
def _both_ways(pairs: OrderedPairs, n: int) -> OrderedPairs:
    """Return (i, j) and (j, i) of pairs of n rows, sorted by i, then j: written row by row, in order of j."""
    one, other = pairs
    begin = np.zeros(n + 1, np.intp)
    for p in range(one.size):
        begin[one[p] + 1] += 1
        begin[other[p] + 1] += 1
    begin = np.cumsum(begin)
    neighbours, end = np.empty(2 * one.size, np.intp), begin[:n].copy()
    for p in range(one.size):
        neighbours[end[one[p]]], neighbours[end[other[p]]] = other[p], one[p]
        end[one[p]] += 1
        end[other[p]] += 1
    i, j, end = np.empty_like(neighbours), np.empty_like(neighbours), begin[:n].copy()
    for row in range(n):
        for neighbour in neighbours[begin[row] : begin[row + 1]]:
            i[end[neighbour]], j[end[neighbour]] = neighbour, row
            end[neighbour] += 1
    return i, j
