"""Columns of the position tracks and parameters of their filter."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from q2q_model.compiled import compiled
from q2q_model.estimation.association.jump_candidates import Table
from q2q_model.signals.values import Array, Mask


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
    frozen_reacquire_s: float


class TrackColumns(NamedTuple):
    """Position tracks in columns."""

    seen: Mask
    """(n,)"""
    confirmed: Mask
    """Tracks in which a second sample has passed the gates, a third if one was refuted, (n,)."""
    refuted: Mask
    """Tracks whose first sample was refuted by the next one, (n,)."""
    time: Array
    """Time of the last accepted sample [s], (n,)."""
    since: Array
    """Time of the first sample of those that equal the last one bit for bit [s], (n,)."""
    varied: NDArray[np.int64]
    """Noisy samples of the slow vehicle since one that repeated, was rounded or as predicted, (n,)."""
    own: NDArray[np.int64]
    """Accepted samples of the track's own name, (n,); without the first if it refuted another."""
    borrowed: NDArray[np.int64]
    """Accepted samples of other names since the last own one, (n,)."""
    state: Array
    """As in kalman_filter, (n, 3, 3)."""
    cov: Array
    """(n, 3, 3)"""


TRACK = np.dtype(
    [
        ("seen", np.bool_),
        ("confirmed", np.bool_),
        ("refuted", np.bool_),
        ("time", np.float64),
        ("since", np.float64),
        ("varied", np.int64),
        ("own", np.int64),
        ("borrowed", np.int64),
        ("state", np.float64, (3, 3)),
        ("cov", np.float64, (3, 3)),
        ("gain", np.float64, 3),  # of q2q_model.estimation.position.steady_gain
    ],
    align=True,
)
"""Row of a table of tracks: one array, which a kernel takes in a tenth of the time of its columns."""


@compiled
def columns_of(table: Table) -> TrackColumns:
    """Return the columns of a table of position tracks, TRACK (n,), as views of it."""
    return TrackColumns(
        table["seen"],
        table["confirmed"],
        table["refuted"],
        table["time"],
        table["since"],
        table["varied"],
        table["own"],
        table["borrowed"],
        table["state"],
        table["cov"],
    )


def unseen(count: int) -> Table:
    """Return a table of tracks without samples, (count,)."""
    return np.zeros(count, TRACK)
