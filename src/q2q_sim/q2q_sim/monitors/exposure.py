"""Ticks at which vehicles are under another, and in clear air, by their positions.

| name | ticks of a vehicle |
|---|---|
| under | another within ASIDE horizontally and up to BELOW above it, now or within the last AFTER seconds |
| clear | none there for FORGOTTEN seconds |

Neither counts the first SETTLE seconds. Between the two, errors of a passage decay.
"""

from typing import NamedTuple

import numpy as np

from q2q_model.signals.values import Array, Mask
from q2q_sim.monitors.proximity import under_another

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
    judged, now = (np.arange(len(pos)) >= round(SETTLE / tick))[:, None], under_another(pos, ASIDE, BELOW)
    return Exposure(
        judged & _recently(now, round(AFTER / tick)), judged & ~_recently(now, round(FORGOTTEN / tick))
    )


def exposed(pos: Array, after: int) -> Mask:
    """Return which vehicles are under another or were up to `after` ticks before, (T, n)."""
    return _recently(under_another(pos, ASIDE, BELOW), after)


def _recently(now: Mask, after: int) -> Mask:
    """Return what is so, or was up to `after` ticks before, (T, n)."""
    count = np.arange(len(now))[:, None]
    last = np.maximum.accumulate(np.where(now, count, -len(now) - after), axis=0)
    return np.asarray(count - last <= after)
