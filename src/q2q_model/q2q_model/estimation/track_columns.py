"""Columns of the position tracks and parameters of their filter."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from q2q_model.flights.outliers import Mask
from q2q_model.signals.values import Array


class TrackParams(NamedTuple):
    """Filter parameters of PositionTracks."""

    pos_max: float
    """[m]"""
    speed_max: float
    """[m/s]"""
    jump_max: float
    """[m]"""
    position_noise: float
    """[m]"""
    jerk_noise: float
    """[m/s^2.5]"""
    coast_s: float
    reacquire_s: float


class TrackColumns(NamedTuple):
    """Position tracks in columns."""

    seen: Mask
    """(n,)"""
    confirmed: Mask
    """TrackColumns in which a second sample has passed the gates, (n,)."""
    time: Array
    """Time of the last accepted sample [s], (n,)."""
    own: NDArray[np.int64]
    """Accepted samples of the track's own name, (n,)."""
    borrowed: NDArray[np.int64]
    """Accepted samples of other names since the last own one, (n,)."""
    state: Array
    """As in white_jerk, (n, 3, 3)."""
    cov: Array
    """(n, 3, 3)"""


def unseen(count: int) -> TrackColumns:
    """Return tracks without samples."""
    no, none, estimate = np.zeros(count, np.bool_), np.zeros(count, np.int64), np.zeros((count, 3, 3))
    return TrackColumns(no, no.copy(), np.zeros(count), none, none.copy(), estimate, estimate.copy())
