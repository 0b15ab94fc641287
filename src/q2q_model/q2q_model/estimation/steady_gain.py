"""Steady-state gain of the Kalman filter, reused while the mocap is nominal.

At a constant period the covariance converges, and with it the gain K. A tick is nominal if every track is
confirmed and accepts the sample of its own name. The gain of a nominal tick in which no vehicle's x repeats
the last frame is kept, with its period, if all tracks have that period and no entry of the covariance changes
by more than CONVERGED. Nominal ticks one period after the last then use it: prediction and gates take the
kept period for the time since the last sample, and the covariance stands still. Any other tick continues the
filter from that covariance.
"""

from typing import NamedTuple

import numpy as np

from q2q_model.estimation.reacquisition import SAME_INSTANT
from q2q_model.signals.values import Array

CONVERGED = 1e-9
"""Largest change of a converged covariance within a tick, relative to the largest of all tracks."""


class SteadyGain(NamedTuple):
    """Gain of every track at a constant period."""

    K: Array
    """(n, 3)"""
    period: float
    """[s]"""
    t: float
    """Last tick [s]."""

    def is_due(self, t: float) -> bool:
        """Return whether a tick at t [s] comes one period after the last."""
        return abs(t - self.t - self.period) <= SAME_INSTANT


def steady_gain(K: Array, tick: tuple[float, Array], covs: tuple[Array, Array]) -> SteadyGain | None:
    """Return the gain if it has converged.

    Args:
        K: Gain of a nominal tick, (n, 3).
        tick: Its time [s], and the time since each track's last sample [s], (n,).
        covs: Covariances of the tracks before and after it, (n, 3, 3) each.
    """
    (t, elapsed), (before, after) = tick, covs
    if not len(elapsed) or np.ptp(elapsed) >= SAME_INSTANT:
        return None
    if (np.abs(after - before) > CONVERGED * np.abs(before).max(axis=0)).any():
        return None
    return SteadyGain(K, float(elapsed[0]), t)
