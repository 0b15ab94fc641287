"""Horizontal direction in which a vehicle evades another that comes down without measurements.

It is the one of eight that keeps the largest distance from all other vehicles, and of those within ALIKE of
that the one of the smallest shift until the other has come to rest.
"""

import numpy as np

from q2q_model.signals.values import Array

DIRECTIONS = 8
ALIKE = 0.1
"""Distances from others that count as equal [m]: less than vehicles are off their positions."""


def evasion_direction(xy: Array, pair: tuple[int, int], rest: Array, reach: float) -> Array:
    """Return the unit vector in which one vehicle evades another, (2,).

    Args:
        xy: positions of all vehicles [m], (n, 2); unknown ones are NaN.
        pair: rows of the evading vehicle and of the other.
        rest: where the other comes to rest [m], (2,).
        reach: distance to keep from it [m].
    """
    offset, other = xy[pair[0]] - xy[pair[1]], xy[pair[1]]
    angles = np.arctan2(offset[1], offset[0]) + np.arange(DIRECTIONS) * (2.0 * np.pi / DIRECTIONS)
    sides = np.stack([np.cos(angles), np.sin(angles)], axis=1)  # (8, 2)
    near = np.hypot(*(xy - other).T) < 2.0 * reach  # others are further than reach from wherever it goes
    near[[*pair]] = False
    room = np.linalg.norm(other + reach * sides[:, None] - xy[near], axis=2).min(axis=1, initial=reach)
    enough = room >= room.max() - ALIKE
    clear = np.minimum(sides @ offset, sides @ (xy[pair[0]] - rest))  # the shift is reach less this
    return np.asarray(sides[int(np.where(enough, clear, -np.inf).argmax())])


def across(direction: Array, offset: Array) -> Array:
    """Return the direction across another, (2,), on the side of an offset [m], (2,)."""
    side = np.array([-direction[1], direction[0]])
    return side if side @ offset >= 0.0 else -side
