"""Share of every vehicle's samples that the gates reject, by stamps: an average that forgets exponentially.

At a frame that comes tau after the one before, with x = 1 for a rejected sample, 0 else,

    s <- e s + (1 - e) x,   e = exp(-min(tau, LONGEST_STEP) / AVERAGE_S)

A frame that is not newer than the last counted one is left out. One older than that by more than AVERAGE_S
means that the stamps restart, as of a clock that was set back: the shares do too.
"""

import math

from q2q_model.signals.values import Names

AVERAGE_S = 2.0
"""Time constant of the average [s]."""
LONGEST_STEP = 0.1
"""Longest time for which one frame counts [s], so that one sample after a gap is not many: 10 Hz."""
WARN_ABOVE = 0.25
"""Share that is too much [-]: of hovering vehicles a tenth is rejected at 1.5 cm of noise, 0.3 at 2 cm."""
CLEAR_BELOW = 0.5 * WARN_ABOVE
"""Share at which it is no longer too much [-]."""
_FORGOTTEN = 1e-4
"""Share below which a vehicle is no longer kept [-]: a fifth of that of one sample at 1000 Hz."""


class RejectedShares:
    """Shares of rejected samples, and the vehicles of which they are too large."""

    def __init__(self) -> None:
        self._t = math.nan
        self._shares: dict[str, float] = {}
        self._many: frozenset[str] = frozenset()

    def update(self, t: float, rejected: Names) -> frozenset[str]:
        """Return the vehicles of which many samples are rejected, after a frame at t [s]."""
        step = t - self._t
        if -AVERAGE_S <= step <= 0.0:  # late or repeated
            return self._many
        self._t = t
        if step < 0.0:  # the stamps restart
            self._shares, self._many = {}, frozenset()
        if not (rejected or self._shares):
            return frozenset()
        kept = math.exp(-min(step, LONGEST_STEP) / AVERAGE_S) if step > 0.0 else 1.0
        shares = {name: kept * share for name, share in self._shares.items()}
        for name in rejected:
            shares[name] = shares.get(name, 0.0) + 1.0 - kept
        self._shares = {
            name: share for name, share in shares.items() if share > _FORGOTTEN or name in rejected
        }
        bounds = {name: CLEAR_BELOW if name in self._many else WARN_ABOVE for name in self._shares}
        self._many = frozenset(name for name, bound in bounds.items() if self._shares[name] > bound)
        return self._many
