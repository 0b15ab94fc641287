"""Candidates for a restart: the places where the rejected samples of each track gather, at most one a track.

A sample joins a candidate if the vehicle could have moved there, |r - r_last| <= jump_max + speed_max
(t - t_last), and t - t_last <= gap_max: GAP_S, or longer where frames come less often (frame_intervals).
"""

import numpy as np
from numpy.typing import NDArray

from q2q_model.estimation.association.outlier_thresholds import OutlierThresholds
from q2q_model.signals.stamps import SAME_INSTANT
from q2q_model.signals.values import Array, Mask

Table = NDArray[np.void]

GAP_S = 0.15
"""Longest time between samples that stay together [s], unless frames come less often: below 10 Hz."""
CANDIDATE = np.dtype(
    [
        ("samples", np.int64),  # 0 is no candidate
        ("first_time", np.float64),
        ("last_time", np.float64),
        ("first_pos", np.float64, 3),
        ("last_pos", np.float64, 3),
        ("gap", np.float64),  # longest time between two samples
        ("gap_max", np.float64),  # longest time to a next sample
        ("ambiguous", np.bool_),
    ]
)
"""Columns of a candidate [s, m]."""


def joins_candidates(candidates: Table, t: float, away: Array, limits: OutlierThresholds) -> Mask:
    """Return which samples at t [s] join candidates, from whose last ones they are `away` [m], (..., n)."""
    since = t - candidates["last_time"]
    recent = (candidates["samples"] > 0) & (since <= candidates["gap_max"] + SAME_INSTANT)
    return np.asarray(recent & (away <= limits.jump_max + limits.speed_max * since))


def mean_velocity(candidates: Table) -> Array:
    """Return the mean velocity of every candidate [m/s], (n, 3); zero for a single sample."""
    lasted = candidates["last_time"] - candidates["first_time"]
    moved = candidates["last_pos"] - candidates["first_pos"]
    return np.asarray(moved / np.where(lasted > 0.0, lasted, np.inf)[:, None])
