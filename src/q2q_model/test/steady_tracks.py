"""Tracks of two vehicles in uniform motion, for tests of single ticks."""

import numpy as np

from q2q_model.estimation.position.position_tracks import PositionTracks
from q2q_model.estimation.position.track_columns import TrackParams
from q2q_model.estimation.position.track_update import TrackUpdate
from q2q_model.signals.values import Array

DT = 1.0 / 64.0
NOISE, JERK, COAST, REACQUIRE, FROZEN = 0.01, 8.0, 0.25, 0.125, 2.0
NEAR = 1e-6
"""On this side or that of a bound [m]."""
PLACES = np.array([[0.0, 0.0, 1.0], [3.0, 0.0, 1.0]])
NOBODY = np.zeros(2, dtype=bool)
"""Vehicles whose pose is repeated."""
NONE = np.full(3, np.nan)


def tracks(speed_max: float = 2.0, count: int = 2) -> PositionTracks:
    return PositionTracks(TrackParams(8.0, speed_max, 0.25, NOISE, JERK, COAST, REACQUIRE, FROZEN), count)


def flown(ticks: int, speed_max: float = 2.0, vel: Array | None = None) -> PositionTracks:
    """Return tracks of two vehicles in uniform motion, with samples at ticks 0 .. ticks - 1."""
    made = tracks(speed_max)
    for k in range(ticks):
        made.update(k * DT, PLACES + (0.0 if vel is None else k * DT * vel), NOBODY)
    return made


def offered(made: PositionTracks, t: float, first: Array) -> TrackUpdate:
    """Return what becomes of a tick; the second vehicle is where it was."""
    return made.update(t, np.stack([first, PLACES[1]]), NOBODY)
