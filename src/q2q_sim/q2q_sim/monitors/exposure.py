"""Ticks at which vehicles are under another, and in clear air, by their positions.

| name | ticks of a vehicle |
|---|---|
| under | another within ASIDE horizontally and up to BELOW above it, now or within the last AFTER seconds |
| clear | none there for FORGOTTEN seconds |

Neither counts the first SETTLE seconds. Between the two, errors of a passage decay.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from q2q_model.signals.values import Array

Mask = NDArray[np.bool_]

SETTLE = 3.0
"""Initial transient that is not measured [s]."""
ASIDE = 0.15
"""Radius of the downwash [m] (real flights)."""
BELOW = 1.5
"""Length of the downwash that counts [m]."""
AFTER = 1.0
"""Time after a pass in which its error counts [s]."""
FORGOTTEN = 3.0
"""Time after which the air counts as clear again [s]."""


class Exposure(NamedTuple):
    """Ticks under another vehicle and in clear air, (T, n) each."""

    under: Mask
    clear: Mask


def exposure(pos: Array, tick: float) -> Exposure:
    """Return the exposure of vehicles at positions (T, n, 3) [m], every `tick` [s]; none in a single tick."""
    if len(pos) < 2:
        return Exposure(np.zeros(pos.shape[:2], dtype=np.bool_), np.zeros(pos.shape[:2], dtype=np.bool_))
    judged = (np.arange(len(pos)) >= round(SETTLE / tick))[:, None]
    return Exposure(
        judged & exposed(pos, round(AFTER / tick)), judged & ~exposed(pos, round(FORGOTTEN / tick))
    )


def exposed(pos: Array, after: int) -> Mask:
    """Return which vehicles are under another or were up to `after` ticks before, (T, n)."""
    ticks, n, _ = pos.shape
    now = np.zeros((ticks, n), dtype=np.bool_)
    x, y, z = np.ascontiguousarray(np.moveaxis(pos, 2, 0))
    for i in range(n):
        dx, dy, dz = (axis - axis[:, i : i + 1] for axis in (x, y, z))  # (T, n)
        near = (dz > 0.0) & (dz < BELOW) & (np.abs(dx) < ASIDE) & (np.abs(dy) < ASIDE)
        near[near] = np.hypot(dx[near], dy[near]) < ASIDE
        now[:, i] = near.any(axis=1)
    count = np.arange(ticks)[:, None]
    last = np.maximum.accumulate(np.where(now, count, -ticks - after), axis=0)
    return np.asarray(count - last <= after)
