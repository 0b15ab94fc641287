"""Separate starting positions on the ground.

Vehicles whose paths start one above the other would overlap on the ground. In turn, each takes the nearest
free point of a grid of SPACING around its own, at least SPACING from those taken and from the first choices
of vehicles not yet placed.
"""

import numpy as np

from q2q_model.signals.values import Array

SPACING = 0.4
"""Smallest distance of two positions [m]: twice a Crazyflie with guards, and clearance."""


def spread_start_positions(desired: Array) -> Array:
    """Return positions (n, 2) at least SPACING apart, as near to `desired` (n, 2) [m] as the order allows."""
    positions = np.array(desired, dtype=np.float64)
    grid = _grid(len(positions))
    for k in range(1, len(positions)):
        if _room(positions[k : k + 1], positions[:k])[0]:
            continue
        others = np.delete(positions, k, axis=0)
        free = positions[k] + grid
        positions[k] = free[np.argmax(_room(free, others))]
    return positions


def _room(candidates: Array, taken: Array) -> Array:
    """Return which candidates (m, 2) are at least SPACING from all taken positions, (m,)."""
    gaps = np.hypot(*np.moveaxis(candidates[:, None] - taken, -1, 0))  # (m, taken)
    return np.asarray((gaps >= SPACING * (1.0 - 1e-9)).all(axis=1))


def _grid(count: int) -> Array:
    """Return offsets [m], nearest first, enough for a free one among `count` vehicles, (m, 2)."""
    reach = int(np.ceil(2.0 * np.sqrt(count))) + 1  # each vehicle blocks at most four of (2 reach + 1)^2
    steps = SPACING * np.arange(-reach, reach + 1)
    grid = np.stack(np.meshgrid(steps, steps, indexing="ij"), axis=-1).reshape(-1, 2)
    return np.asarray(grid[np.argsort(np.hypot(*grid.T), kind="stable")])
