"""Ticks of a recorded flight: the stamps of its truth, and those of its frames where truth is lost.

The simulator stamps the truth with the times of its ticks, whatever the stamps of the frames. A truth of
another rate is not stamped tick by tick: then the frames are the ticks.
"""

import numpy as np

from q2q_model.signals.values import Array

GAP = 1.5
"""Time between two ticks, over the usual one, from which one between them is missing [-]."""


def flight_ticks(truth: Array, frames: Array) -> Array:
    """Return the ticks [s], rising, (T,).

    Args:
        truth: stamps of the truth [s]; some may be lost.
        frames: stamps of motion capture [s]; a clock jump may make them those of other ticks.
    """
    true, framed = np.unique(truth), np.unique(frames)
    period, frame_period = _period(true), _period(framed)
    if np.isinf(frame_period):
        return true
    if not frame_period / GAP <= period <= frame_period * GAP:
        return framed
    return np.union1d(true, _ticks_without_truth(true, framed, len(frames) - len(truth)))


def _period(stamps: Array) -> float:
    """Return the usual time between rising stamps [s]; infinite for fewer than two."""
    return float(np.median(np.diff(stamps))) if len(stamps) > 1 else np.inf


def _ticks_without_truth(true: Array, framed: Array, lost: int) -> Array:
    """Return the stamps of frames in gaps of the truth, and of as many beside it as it has lost ones [s].

    Frames outside the truth may be stamped by a clock that jumped; then the truth has not lost theirs.
    """
    after = np.clip(np.searchsorted(true, framed), 1, len(true) - 1)
    away = np.minimum(np.abs(framed - true[after - 1]), np.abs(framed - true[after])) / _period(true)
    apart = away > 0.5 * GAP
    within = apart & (true[0] < framed) & (framed < true[-1])
    left = max(lost - int(within.sum()), 0)
    outside = np.flatnonzero(apart & ~within & (away < GAP * left))
    nearest = outside[np.argsort(away[outside], kind="stable")][:left]
    return np.concatenate((framed[within], framed[nearest]))
