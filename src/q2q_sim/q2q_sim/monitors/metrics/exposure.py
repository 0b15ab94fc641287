"""Ticks at which vehicles are under another, and in clear air, by their positions.

| name | ticks of a vehicle |
|---|---|
| under | another within ASIDE horizontally and up to BELOW above it, now or within the last AFTER seconds |
| clear | none there for FORGOTTEN seconds, in which the positions of all others are known |

Neither counts the first SETTLE seconds. Between the two, errors of a passage decay.
"""

from typing import NamedTuple

import numpy as np

from q2q_model.flights.masks_over_time import last_time
from q2q_model.signals.stamps import SAME_STAMP
from q2q_model.signals.values import Array, Mask
from q2q_sim.monitors.metrics.proximity import under_another

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


def exposure(pos: Array, t: Array) -> Exposure:
    """Return the exposure of vehicles at positions (T, n, 3) [m], NaN where unknown, at times (T,) [s]."""
    judged, now = (t - t[:1] >= SETTLE - SAME_STAMP)[:, None], under_another(pos, ASIDE, BELOW)
    return Exposure(
        judged & _recently(now, t, AFTER), judged & ~_recently(now | _lacks_another(pos), t, FORGOTTEN)
    )


def exposed(pos: Array, t: Array, after: float) -> Mask:
    """Return which vehicles are under another, or were up to `after` [s] before, (T, n)."""
    return _recently(under_another(pos, ASIDE, BELOW), t, after)


def _lacks_another(pos: Array) -> Mask:
    """Return which vehicles are flown while the position of another is unknown, (T, n)."""
    unknown = ~np.isfinite(pos).all(axis=2)
    return np.asarray(unknown.sum(axis=1, keepdims=True) > unknown)


def _recently(now: Mask, t: Array, after: float) -> Mask:
    """Return what is so, or was up to `after` [s] before, (T, n)."""
    return np.asarray(t[:, None] - last_time(now, t) <= after + SAME_STAMP)
