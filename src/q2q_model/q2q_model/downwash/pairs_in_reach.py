"""Broad phase: all pairs within reach, by sweep and prune over x.

With vehicles sorted by x, the neighbours of a vehicle lie in the rows up to an x difference of the reach. At
bounded density the number of these rows does not grow with n, so sorting costs n log n and sweeping n; a
dense comparison costs n^2.
"""

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.downwash.interaction_model import Reach
from q2q_model.signals.values import Array, Rows


def pairs_in_reach(pos: Array, reach: Reach) -> tuple[Rows, Rows]:
    """Return rows (i, j) of all ordered pairs within reach, sorted by i, then j.

    Contains both (i, j) and (j, i), i != j. A vehicle with a NaN coordinate is in no pair.

    Args:
        pos: positions [m], world, (n, 3).
        reach: largest horizontal and vertical distance of a pair.
    """
    keys = sweep(np.ascontiguousarray(pos), reach.horizontal, reach.vertical)
    i, j = np.divmod(keys, max(len(pos), 1))
    return i, j


@compiled
def sweep(pos: Array, horizontal: float, vertical: float) -> Rows:
    """Return n i + j of every pair of pos (n, 3) within the reaches [m], ascending."""
    n = pos.shape[0]
    order = np.argsort(pos[:, 0])  # NaN sorts last
    keys = np.empty(8 * n, np.intp)
    count = 0
    for a in range(n):
        i = order[a]
        for b in range(a + 1, n):
            j = order[b]
            dx = pos[j, 0] - pos[i, 0]
            if not dx <= horizontal:  # also ends at NaN
                break
            dy, dz = pos[j, 1] - pos[i, 1], pos[j, 2] - pos[i, 2]
            if dx * dx + dy * dy <= horizontal * horizontal and abs(dz) <= vertical:
                if count + 2 > keys.size:
                    keys = np.concatenate((keys, np.empty_like(keys)))
                keys[count], keys[count + 1] = n * i + j, n * j + i
                count += 2
    return np.sort(keys[:count])
