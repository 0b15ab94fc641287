"""Find each vehicle its own spot on the ground.

Vehicles whose paths begin one above the other would stand in each other. In their order, each takes the free
spot nearest to its own: on a grid of SPACING around it, and SPACING from those taken and from the spots of
vehicles that have not been placed, which keep theirs.
"""

import numpy as np

from q2q_model.signals.values import Array

SPACING = 0.4
"""Least distance of two spots [m]: twice a Crazyflie with guards, and room to set it down."""


def apart(wanted: Array) -> Array:
    """Return spots (n, 2) at least SPACING apart, each as near to `wanted` (n, 2) [m] as the order allows."""
    spots = np.array(wanted, dtype=np.float64)
    grid = _grid(len(spots))
    for k in range(1, len(spots)):
        if _room(spots[k : k + 1], spots[:k])[0]:
            continue
        others = np.delete(spots, k, axis=0)
        free = spots[k] + grid
        spots[k] = free[np.argmax(_room(free, others))]
    return spots


def _room(candidates: Array, taken: Array) -> Array:
    """Return which candidates (m, 2) are SPACING from all that are taken, (m,)."""
    gaps = np.hypot(*np.moveaxis(candidates[:, None] - taken, -1, 0))  # (m, taken)
    return np.asarray((gaps >= SPACING * (1.0 - 1e-9)).all(axis=1))


def _grid(count: int) -> Array:
    """Return offsets [m], nearest first, of which some are free among `count` vehicles, (m, 2)."""
    reach = int(np.ceil(2.0 * np.sqrt(count))) + 1  # each vehicle blocks at most four of (2 reach + 1)^2
    steps = SPACING * np.arange(-reach, reach + 1)
    grid = np.stack(np.meshgrid(steps, steps, indexing="ij"), axis=-1).reshape(-1, 2)
    return np.asarray(grid[np.argsort(np.hypot(*grid.T), kind="stable")])
