"""Poses that repeat under the name of another vehicle, which stands there.

A pose that repeats and fails the gates of its track is no sample (position_gates), as a server that has lost
a body may send its last pose again. Where it is that of another vehicle that has no sample of its own, names
are exchanged: in a simulator without noise, poses of a vehicle that stands repeat.
"""

import numpy as np

from q2q_model.estimation.position.position_prediction import THAW_STEP, Prediction
from q2q_model.signals.values import Array, Mask


def with_exchanged_repeats(at: Prediction, measured: Array, seen: Mask) -> Prediction:
    """Return the prediction of a tick with the samples that stand where another track waits for one.

    Args:
        at: Tracks predicted to the tick.
        measured: Positions [m], (n, 3); NaN where absent.
        seen: Tracks that have had a sample, (n,).
    """
    waiting = np.flatnonzero(seen & ~at.own & ~at.lost)
    rows = np.flatnonzero(at.repeated & ~at.own & ~at.frozen)
    away = np.linalg.norm(measured[rows, None] - at.state[None, waiting, 0], axis=2)
    there = (away <= THAW_STEP) & (rows[:, None] != waiting)
    samples = at.samples.copy()
    samples[rows] = np.where(there.any(axis=1)[:, None], measured[rows], samples[rows])
    return at._replace(samples=samples)
