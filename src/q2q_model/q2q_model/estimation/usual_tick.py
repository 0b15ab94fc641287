"""Usual tick of the mocap filter in one kernel: every pose is accepted by the track of its own name.

Nearly every tick is usual. Positions are those of q2q_model.estimation.positions, attitudes those of
q2q_model.estimation.attitudes; for ten vehicles, one call takes a third of the time of several.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from q2q_model.compiled import compiled
from q2q_model.estimation.association.jump_candidates import Table
from q2q_model.estimation.attitudes import AttitudeGateParams
from q2q_model.estimation.attitudes import follow as follow_attitudes
from q2q_model.estimation.position_steps import UNUSUAL, Offered, TrackMemory
from q2q_model.estimation.position_steps import follow as follow_positions
from q2q_model.estimation.track_columns import TrackParams
from q2q_model.flights.outliers import Mask
from q2q_model.signals.values import Array

QUAT_AT, POSE_WIDTH = 3, 7
"""Poses are position [m] and orientation x y z w of every vehicle, (n, 7); NaN where absent."""
RECENT = 35
"""Frames whose poses are remembered: 0.35 s at 100 Hz, for which a vehicle may coast."""


class RecentPoses(NamedTuple):
    """Poses of the last frames."""

    poses: Array
    """A ring, (RECENT, n, 7); NaN where absent."""
    newest: NDArray[np.int64]
    """Row of the last frame, (1,)."""


def no_poses(count: int) -> RecentPoses:
    """Return the memory of `count` vehicles before the first frame."""
    return RecentPoses(np.full((RECENT, count, POSE_WIDTH), np.nan), np.zeros(1, np.int64))


def with_more(recent: RecentPoses, extra: int) -> RecentPoses:
    """Return the memory with `extra` vehicles more."""
    return RecentPoses(np.concatenate((recent.poses, no_poses(extra).poses), axis=1), recent.newest)


@compiled
def remember_poses(now: Array, recent: RecentPoses) -> None:
    """Take the poses (n, 7) of a frame in place of the oldest."""
    recent.newest[0] = (recent.newest[0] + 1) % RECENT
    recent.poses[recent.newest[0]] = now


@compiled
def repeated_poses(now: Array, recent: RecentPoses) -> tuple[Mask, bool]:
    """Return which poses (n, 7) equal a recent one bit for bit, (n,), and whether every x is new."""
    same, fresh, poses = np.zeros(len(now), np.bool_), True, recent.poses
    for i in range(len(now)):
        for row in range(RECENT):
            if now[i, 0] == poses[row, i, 0]:
                same[i] = same[i] or _equal(now[i], poses[row, i])
                fresh = fresh and row != recent.newest[0]
    return same, fresh


@compiled
def _equal(one: Array, other: Array) -> bool:
    """Return whether two poses (7,) are the same; orientations may be unknown."""
    for k in range(POSE_WIDTH):
        absent = k >= QUAT_AT and math.isnan(one[k]) and math.isnan(other[k])
        if not (absent or one[k] == other[k]):
            return False
    return True


@compiled
def usual_tick(
    t: float,
    poses: tuple[Array, RecentPoses],
    params: tuple[TrackParams, AttitudeGateParams],
    memory: tuple[TrackMemory, Table],
    out: tuple[Array, Array, Array, Array],
) -> tuple[int, bool]:
    """Take the poses of a usual tick; return the outcome for positions, and whether attitudes are usual, too.

    Args:
        t: Time [s].
        poses: Of this frame, (n, 7), and those before.
        params: Of positions and attitudes.
        memory: Of positions and attitudes.
        out: Written as far as usual: pos, vel, quat and ang_vel_body of the state, (n, 3) or (n, 4) each.
    """
    (now, recent), (pos, vel, quat, ang_vel_body) = poses, out
    repeated, fresh = repeated_poses(now, recent)
    offered = Offered(now[:, :QUAT_AT].copy(), repeated, fresh)
    outcome = follow_positions(t, offered, params[0], memory[0], (pos, vel))
    turned = outcome != UNUSUAL and follow_attitudes(t, now[:, QUAT_AT:], params[1], memory[1])
    if turned:
        quat[:], ang_vel_body[:] = memory[1]["quat"], memory[1]["ang_vel_body"]
    return outcome, turned
