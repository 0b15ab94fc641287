"""Broad phase: the pairs that can affect each other in a tick, by a sweep over sorted x.

A pair is kept if the two might not stop apart (their stopping distances, with all growth, overlap), or if
the barrier might push: the required n.(a_i - a_j) is above what accelerations can be. Only rows whose x
differ by less than the largest reach are compared, so at bounded density the cost grows as n log n.
"""

from collections.abc import Callable

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array
from q2q_planner.online.safe.barrier import Rows

Limits = tuple[int, float, float, float, float, float]
"""Rows of the swarm, eps [m], d [m], largest reach [m], pole of the approach [1/s], largest push [m/s^2]."""


def broad_phase(pos: Array, vel: Array, room: tuple[Array, Array], limits: Limits) -> tuple[Rows, Rows]:
    """Return rows i < j, i of the swarm, of all pairs that can affect each other.

    Args:
        pos: [m], (rows, 3); a row with NaN is in no pair.
        vel: [m/s], (rows, 3).
        room: stopping distance of each row with all growth [m], (rows,), and growth g0, g1, (rows, 2).
        limits: see Limits.
    """
    order = np.argsort(pos[:, 0])  # NaN sorts last
    i, j = _sweep_of(np.ascontiguousarray(pos), np.ascontiguousarray(vel), order, room, limits)
    return i, j


def _sweep(
    pos: Array, vel: Array, order: Rows, room: tuple[Array, Array], limits: Limits
) -> tuple[Rows, Rows]:
    own, eps, d, reach, pole, push = limits
    ways, growth = room
    first, second = np.empty(4 * len(order), np.intp), np.empty(4 * len(order), np.intp)
    count = 0
    for a in range(len(order)):
        for b in range(a + 1, len(order)):
            i, j = min(order[a], order[b]), max(order[a], order[b])
            x = pos[i, 0] - pos[j, 0]
            if not abs(x) <= reach:  # also ends at NaN
                break
            y, z = pos[i, 1] - pos[j, 1], pos[i, 2] - pos[j, 2]
            if i >= own or not abs(y) <= reach or not abs(z) <= reach + d:
                continue
            across = np.sqrt(x * x + y * y)
            side, cap = across - eps, abs(z) - d
            h = max(side, cap) - growth[i, 0] - growth[j, 0]
            u, v, w = vel[i, 0] - vel[j, 0], vel[i, 1] - vel[j, 1], vel[i, 2] - vel[j, 2]
            closing = abs(w) if cap > 0.0 else 0.0
            closing += max(0.0, -(x * u + y * v) / across) if side > 0.0 else 0.0
            closing += growth[i, 1] + growth[j, 1]
            if h > ways[i] + ways[j] and 2.0 * pole * closing + push < pole * pole * h:
                continue
            if count == first.size:
                first, second = np.concatenate((first, first)), np.concatenate((second, second))
            first[count], second[count] = i, j
            count += 1
    return first[:count], second[:count]


_sweep_of: Callable[[Array, Array, Rows, tuple[Array, Array], Limits], tuple[Rows, Rows]] = compiled(_sweep)
