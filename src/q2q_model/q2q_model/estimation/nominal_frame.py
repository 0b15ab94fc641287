"""Nominal frame of the mocap filter in one kernel: every pose is accepted by the track of its own name.

Nearly every frame is nominal. Positions are those of q2q_model.estimation.position, attitudes those of
q2q_model.estimation.attitude; for ten vehicles, one call takes a third of the time of several.
"""

import math

import numpy as np
from numpy.typing import NDArray

from q2q_model.compiled import compiled
from q2q_model.estimation.association.jump_candidates import Table
from q2q_model.estimation.attitude.attitude_steps import AttitudeGateParams, follow_attitudes
from q2q_model.estimation.position.position_steps import (
    NEEDS_ASSOCIATION,
    WHOLE,
    Offered,
    TrackMemory,
    follow_positions,
)
from q2q_model.estimation.position.track_columns import TrackParams
from q2q_model.signals.values import Array, Mask

QUAT_AT, POSE_WIDTH = 3, 7
"""Poses are position [m] and orientation x y z w of every vehicle, (n, 7); NaN where absent."""
RECENT = 35
"""Frames whose poses are remembered: 0.35 s at 100 Hz, for which a vehicle may coast."""

Floats = tuple[float, ...]
Memory = tuple[Table, Table, Array, Table]
"""Fields of a TrackMemory, then the table of AttitudeTracks."""
RecentPoses = tuple[Array, NDArray[np.int64]]
"""Poses of the last frames: a ring, (RECENT, n, 7), NaN where absent; and the row of the last one, (1,)."""


def no_poses(count: int) -> RecentPoses:
    """Return the memory of `count` vehicles before the first frame."""
    return np.full((RECENT, count, POSE_WIDTH), np.nan), np.zeros(1, np.int64)


def extend_memory(recent: RecentPoses, extra: int) -> RecentPoses:
    """Return the memory with `extra` vehicles more."""
    poses, newest = recent
    return np.concatenate((poses, no_poses(extra)[0]), axis=1), newest


def keep_memory(recent: RecentPoses, kept: Mask) -> RecentPoses:
    """Return the memory of some of the vehicles, (n,)."""
    poses, newest = recent
    return np.ascontiguousarray(poses[:, kept]), newest


@compiled
def remember_poses(now: Array, recent: RecentPoses) -> None:
    """Take the poses (n, 7) of a frame in place of the oldest."""
    poses, newest = recent
    newest[0] = (newest[0] + 1) % RECENT
    poses[newest[0]] = now


@compiled
def repeated_poses(now: Array, recent: RecentPoses) -> tuple[Mask, bool]:
    """Return which poses (n, 7) equal a recent one bit for bit, (n,), and Offered.fresh."""
    same, fresh, (poses, newest) = np.zeros(len(now), np.bool_), True, recent
    for i in range(len(now)):
        for row in range(RECENT):
            if now[i, 0] == poses[row, i, 0]:
                same[i] = same[i] or _equal(now[i], poses[row, i])
                fresh = fresh and row != newest[0]
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
def nominal_frame(
    t: float,
    poses: tuple[Array, RecentPoses],
    params: tuple[Floats, Floats],
    memory: Memory,
    out: tuple[Array, Array, Array, Array],
) -> tuple[int, bool, Mask]:
    """Take the poses of a nominal tick.

    Args:
        t: Time [s].
        poses: Of this frame, (n, 7), and those before, which a wholly nominal tick joins.
        params: Of TrackParams and AttitudeGateParams.
        memory: Of positions and attitudes.
        out: Written as far as taken: pos, vel, quat and ang_vel_body of the state, (n, 3) or (n, 4) each.

    Returns:
        The outcome for positions, whether attitudes were taken, too, and which poses repeat, (n,).

    Parameters and memory come as plain tuples: numba takes named ones in three times the time.
    """
    (now, recent), (pos, vel, quat, ang_vel_body) = poses, out
    repeated, fresh = repeated_poses(now, recent)
    tracks, candidates, clock, attitudes = memory
    offered = Offered(now[:, :QUAT_AT].copy(), repeated, fresh)
    tracked = TrackMemory(tracks, candidates, clock)
    outcome = follow_positions(t, offered, TrackParams(*params[0]), tracked, (pos, vel))
    gate = AttitudeGateParams(*params[1])
    turned = outcome != NEEDS_ASSOCIATION and follow_attitudes(t, now[:, QUAT_AT:], gate, attitudes)
    if turned:
        quat[:], ang_vel_body[:] = attitudes["quat"], attitudes["ang_vel_body"]
    if turned and outcome == WHOLE:
        remember_poses(now, recent)
    return outcome, turned, repeated
