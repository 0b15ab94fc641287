"""Usual tick of the mocap filter in one kernel: every pose is accepted by the track of its own name.

Nearly every tick is usual. Positions are those of q2q_model.estimation.positions, attitudes those of
q2q_model.estimation.attitudes; for ten vehicles, one call takes a third of the time of several.
"""

import math

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.estimation.attitudes import AttitudeGateParams
from q2q_model.estimation.attitudes import follow as follow_attitudes
from q2q_model.estimation.position_steps import UNUSUAL, Offered, TrackMemory
from q2q_model.estimation.position_steps import follow as follow_positions
from q2q_model.estimation.reacquisition import Table
from q2q_model.estimation.track_columns import TrackParams
from q2q_model.flights.outliers import Mask
from q2q_model.signals.values import Array

QUAT_AT, POSE_WIDTH = 3, 7
"""Poses are position [m] and orientation x y z w of every vehicle, (n, 7); NaN where absent."""


@compiled
def repeated_poses(now: Array, before: Array) -> tuple[Mask, bool]:
    """Return which poses (n, 7) equal the last frame's bit for bit, (n,), and whether no x does."""
    same, fresh = np.zeros(len(now), np.bool_), True
    for i in range(len(now)):
        if now[i, 0] != before[i, 0]:
            continue
        same[i], fresh = True, False
        for k in range(POSE_WIDTH):
            absent = k >= QUAT_AT and math.isnan(now[i, k]) and math.isnan(before[i, k])
            same[i] = same[i] and (absent or now[i, k] == before[i, k])
    return same, fresh


@compiled
def usual_tick(
    t: float,
    poses: tuple[Array, Array],
    params: tuple[TrackParams, AttitudeGateParams],
    memory: tuple[TrackMemory, Table],
    out: tuple[Array, Array, Array, Array],
) -> tuple[int, bool]:
    """Take the poses of a usual tick; return the outcome for positions, and whether attitudes are usual, too.

    Args:
        t: Time [s].
        poses: Of this frame and of the last one, (n, 7) each.
        params: Of positions and attitudes.
        memory: Of positions and attitudes.
        out: Written as far as usual: pos, vel, quat and ang_vel_body of the state, (n, 3) or (n, 4) each.
    """
    (now, before), (pos, vel, quat, ang_vel_body) = poses, out
    repeated, fresh = repeated_poses(now, before)
    offered = Offered(now[:, :QUAT_AT].copy(), repeated, fresh)
    outcome = follow_positions(t, offered, params[0], memory[0], (pos, vel))
    turned = outcome != UNUSUAL and follow_attitudes(t, now[:, QUAT_AT:], params[1], memory[1])
    if turned:
        quat[:], ang_vel_body[:] = memory[1]["quat"], memory[1]["ang_vel_body"]
    return outcome, turned
