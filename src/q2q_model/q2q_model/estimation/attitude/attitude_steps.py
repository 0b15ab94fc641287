"""Compiled step of the attitude tracks in a nominal tick: no attitude is new, rejected or upside down.

Gates and symbols are those of q2q_model.estimation.attitude.attitude_tracks, which takes all other ticks.
"""

import math
from typing import NamedTuple

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.estimation.association.jump_candidates import Table
from q2q_model.signals.values import Array, Mask

UNIT_TOLERANCE = 0.05
"""Largest deviation of a valid quaternion's length from 1: float32 has 1e-6, four digits have 1e-3."""
_TINY = 1e-150
"""Stands for zero in the sine of a turn."""


class AttitudeGateParams(NamedTuple):
    """Filter parameters of AttitudeTracks."""

    turn_max: float
    """[rad]"""
    turn_rate_max: float
    """[rad/s]"""
    rate_filter_s: float
    reacquire_s: float
    flip_reacquire_s: float
    coast_s: float


ATTITUDE = np.dtype(
    [
        ("seen", np.bool_),
        ("time", np.float64),
        ("rejected_since", np.float64),
        ("quat", np.float64, 4),
        ("ang_vel_body", np.float64, 3),
    ],
    align=True,
)
"""Row of a table of attitude tracks: one array, as q2q_model.estimation.position.track_columns.TRACK."""


class Attitudes(NamedTuple):
    """Attitude track of every vehicle, in columns of a table."""

    seen: Mask
    """(n,)"""
    time: Array
    """Time of the last accepted attitude [s], (n,)."""
    rejected_since: Array
    """Time of the first of the current rejections [s], (n,), of the last for a vehicle never seen; infinite
    without."""
    quat: Array
    """Orientation x y z w, (n, 4); level for a vehicle never seen."""
    ang_vel_body: Array
    """Body rate [rad/s], (n, 3)."""


@compiled
def attitude_columns(table: Table) -> Attitudes:
    """Return the columns of a table of attitude tracks, ATTITUDE (n,), as views of it."""
    return Attitudes(
        table["seen"], table["time"], table["rejected_since"], table["quat"], table["ang_vel_body"]
    )


@compiled
def follow_attitudes(t: float, measured: Array, params: AttitudeGateParams, table: Table) -> bool:
    """Take one tick's attitudes x y z w (n, 4) at t [s]; False, and no track changed, unless all are taken.

    They are if no track is new or rejected samples before, and every sample is absent, or passes the gate
    with body z up. `table` is ATTITUDE, (n,).
    """
    tracks = attitude_columns(table)
    turn = np.empty(4)
    for i in range(len(measured)):
        elapsed = t - tracks.time[i]
        if not tracks.seen[i] or tracks.rejected_since[i] < math.inf:
            return False
        if not _absent(measured[i]) and not (
            _turn(tracks.quat[i], measured[i], turn) > 0.0
            and elapsed <= params.coast_s
            and _is_plausible(turn, elapsed, params)
            and _points_up(measured[i])
        ):
            return False
    for i in range(len(measured)):
        if _absent(measured[i]):
            tracks.ang_vel_body[i] = 0.0
            continue
        length = _turn(tracks.quat[i], measured[i], turn)
        _follow(turn, t - tracks.time[i], params.rate_filter_s, tracks.ang_vel_body[i])
        tracks.time[i] = t
        for k in range(4):
            tracks.quat[i, k] = math.copysign(1.0, turn[3]) * measured[i, k] / length
    return True


@compiled
def _absent(quat: Array) -> bool:
    return math.isnan(quat[0] + quat[1] + quat[2] + quat[3])


@compiled
def _turn(last: Array, measured: Array, turn: Array) -> float:
    """Write q0* q / |q|; return |q|, NaN where q is absent or invalid."""
    x, y, z, w = measured[0], measured[1], measured[2], measured[3]
    length = math.sqrt(x * x + y * y + z * z + w * w)
    if not abs(length - 1.0) <= UNIT_TOLERANCE:
        return math.nan
    x, y, z, w = x / length, y / length, z / length, w / length
    a, b, c, d = -last[0], -last[1], -last[2], last[3]
    turn[0] = d * x + a * w + b * z - c * y
    turn[1] = d * y + b * w + c * x - a * z
    turn[2] = d * z + c * w + a * y - b * x
    turn[3] = d * w - a * x - b * y - c * z
    return length


@compiled
def _is_plausible(turn: Array, elapsed: float, params: AttitudeGateParams) -> bool:
    """Return whether a turn within `elapsed` [s] passes the gate."""
    largest = params.turn_max + params.turn_rate_max * elapsed
    return bool(abs(turn[3]) >= math.cos(0.5 * min(largest, math.pi)))


@compiled
def _points_up(measured: Array) -> bool:
    """Return whether body z of a quaternion points up."""
    x, y, z, w = measured[0], measured[1], measured[2], measured[3]
    return bool(x * x + y * y < z * z + w * w)


@compiled
def _follow(turn: Array, elapsed: float, lag: float, rate: Array) -> None:
    """Move the body rate on by a turn within `elapsed` [s]."""
    sine = max(math.sqrt(turn[0] * turn[0] + turn[1] * turn[1] + turn[2] * turn[2]), _TINY)
    scale = math.copysign(1.0, turn[3]) * 2.0 * math.atan2(sine, abs(turn[3])) / sine / elapsed
    for k in range(3):
        rate[k] += elapsed / (elapsed + lag) * (scale * turn[k] - rate[k])
