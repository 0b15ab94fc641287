"""Steady-state gain of the Kalman filter, reused while the mocap is nominal.

At a constant period the covariance converges, and with it the gain K. A tick is nominal if every track is
confirmed and accepts the sample of its own name. The gain of a nominal tick in which no vehicle's x repeats
the last frame is kept, with its period, if all tracks have that period and no entry of the covariance changes
by more than CONVERGED. Nominal ticks one period after the last then use it: prediction and gates take the
kept period for the time since the last sample, and the covariance stands still. Any other tick continues the
filter from that covariance.
"""

import math

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.signals.stamps import SAME_INSTANT
from q2q_model.signals.values import Array

CONVERGED = 1e-9
"""Largest change of a converged covariance within a tick, relative to the largest of all tracks."""
PERIOD, LAST = 0, 1
"""Entries of a clock: period of a steady gain [s], NaN without; last tick [s]."""


@compiled
def is_due(clock: Array, t: float) -> bool:
    """Return whether a tick at t [s] comes one steady period after the last; `clock` (2,) is PERIOD, LAST."""
    return bool(abs(t - clock[LAST] - clock[PERIOD]) <= SAME_INSTANT)


@compiled
def steady_period(elapsed: Array, before: Array, after: Array) -> float:
    """Return the period of a nominal tick whose gain has converged [s], else NaN.

    Args:
        elapsed: Time since each track's last sample [s], (n,).
        before: Covariances of the tracks before the tick, (n, 3, 3).
        after: The same after it.
    """
    if not elapsed.size or elapsed.max() - elapsed.min() >= SAME_INSTANT:
        return math.nan
    for row in range(3):
        for k in range(3):
            largest = np.abs(before[:, row, k]).max()
            for i in range(elapsed.size):
                if abs(after[i, row, k] - before[i, row, k]) > CONVERGED * largest:
                    return math.nan
    return float(elapsed[0])
