"""End of the downwash of a pair, by one rule for every model.

    none where |dz(t - tau)| > vertical, or where |dxy(t - tau)| > horizontal and |dxy(t)| > horizontal

with d the offset r_j - r_i of the source when its air left it, which is that of the law, and now. The height
difference is that of the law alone. Sideways both count: air that falls straight down stays at the first
offset, and air that keeps all of its source's velocity arrives at the second, so the jet of a fast source may
meet a vehicle from which it left farther than `horizontal`.

The rule uses the pair alone. A search for pairs before tau is known takes more of them: it widens the reach
by how far sources have moved since, and by `SLACK`. The rule then decides, so no search shows in a value.
"""

import numpy as np

from q2q_model.compiled import HOT, compiled
from q2q_model.signals.values import Array, Mask

SLACK = 1e-6
"""Widening of each search for pairs [m]: rounding loses none."""


def beyond_reach(rel_pos: Array, now: Array, reach: tuple[float, float]) -> Mask:
    """Return which pairs have no downwash, (...,); not one whose offset is not a number.

    Args:
        rel_pos: r_j(t - tau) - r_i(t) [m], world, (..., 3).
        now: r_j(t) - r_i(t) [m], world, (..., 3).
        reach: horizontal and vertical [m].
    """
    left, there = (np.ascontiguousarray(one, dtype=np.float64).reshape(-1, 3) for one in (rel_pos, now))
    return np.asarray(beyond_rows(left, there, reach).reshape(rel_pos.shape[:-1]))


@compiled
def beyond_rows(rel_pos: Array, now: Array, reach: tuple[float, float]) -> Mask:
    """Return which pairs in rows (p, 3) have no downwash, (p,); arguments as of `beyond_reach`."""
    beyond = np.empty(rel_pos.shape[0], np.bool_)
    for p in range(beyond.size):
        beyond[p] = is_beyond_reach(rel_pos[p], now[p], reach)
    return beyond


@compiled(**HOT)
def is_beyond_reach(rel_pos: Array, now: Array, reach: tuple[float, float]) -> bool:
    """Return whether one pair has no downwash; rel_pos (3,), now (3,) and reach are as in `beyond_reach`."""
    horizontal, vertical = reach
    farthest = horizontal * horizontal
    aside = rel_pos[0] * rel_pos[0] + rel_pos[1] * rel_pos[1] > farthest
    return bool(abs(rel_pos[2]) > vertical or (aside and now[0] * now[0] + now[1] * now[1] > farthest))
