"""Decay of predicted downwash whose source has not been measured for a while.

The predictor holds a coasting or lost source at its last position; compensating its downwash indefinitely
would accelerate a vehicle without need. So downwash marked STALE_SOURCE decays:

    eta_used = eta exp(-(t - t_valid) / fade_time)         t_valid: time it was last not stale

A dropout of 0.1 to 0.3 s leaves most of the downwash. That which is stale in its first message counts as
valid a tick ago.
"""

import numpy as np

from q2q_model.signals.stamps import TICK_S
from q2q_model.signals.values import STALE_SOURCE, Interference


class StaleDownwashFade:
    """Time at which each vehicle's predicted downwash was last based on measured sources."""

    def __init__(self, fade_time: float) -> None:
        """Fade stale downwash with a time constant of `fade_time` [s]."""
        self._fade_time = fade_time
        self._valid: dict[str, float] = {}
        self._t = -np.inf

    def reset(self) -> None:
        """Forget everything."""
        self._valid = {}
        self._t = -np.inf

    def faded(self, interference: Interference | None) -> Interference | None:
        """Return the downwash to use at this tick."""
        if interference is None or not np.count_nonzero(interference.status):
            self._valid = {}
            self._t = -np.inf if interference is None else interference.t
            return interference
        rows = np.flatnonzero(interference.status == STALE_SOURCE)
        stale = [interference.names[row] for row in rows]
        first = max(self._t, interference.t - TICK_S)
        since = np.array([self._valid.setdefault(name, first) for name in stale])
        share = np.ones(len(interference.names))
        share[rows] = np.exp(-np.maximum(interference.t - since, 0.0) / self._fade_time)
        for name in (self._valid.keys() - stale) & set(interference.names):
            del self._valid[name]
        self._t = interference.t
        return Interference(
            t=interference.t,
            names=interference.names,
            acc=interference.acc * share[:, None],
            std=interference.std,
            status=interference.status,
        )
