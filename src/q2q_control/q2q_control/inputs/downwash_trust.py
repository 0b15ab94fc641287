"""Fade predicted downwash when its source has not been seen for a while.

A source that coasts or is lost stays, for the predictor, where it was; compensating its downwash for ever
would push a vehicle that nothing pushes. So downwash marked STALE_SOURCE counts less and less:

    eta_used = eta exp(-(t - t_valid) / fade_time)         t_valid: when it was last not stale

A source that is gone for a dropout of 0.1 to 0.3 s keeps most of its downwash.
"""

import numpy as np

from q2q_model.signals.values import Interference, InterferenceStatus

FIRST = 0.01
"""Downwash that is stale when it is first heard of counts as valid a tick ago [s]."""
_STALE = int(InterferenceStatus.STALE_SOURCE)


class DownwashTrust:
    """Time at which each vehicle's predicted downwash was last based on sources that were seen."""

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
        """Return the downwash to be used at this tick."""
        if interference is None or not interference.status.any():
            self._valid = {}
            self._t = -np.inf if interference is None else interference.t
            return interference
        share, names = np.ones(len(interference.names)), interference.names
        stale = {names[row]: row for row in np.flatnonzero(interference.status == _STALE)}
        for name, row in stale.items():
            since = self._valid.setdefault(name, max(self._t, interference.t - FIRST))
            share[row] = np.exp(-max(interference.t - since, 0.0) / self._fade_time)
        for name in self._valid.keys() & set(names) - stale.keys():
            del self._valid[name]
        self._t = interference.t
        return Interference(
            t=interference.t,
            names=interference.names,
            acc=interference.acc * share[:, None],
            std=interference.std,
            status=interference.status,
        )
