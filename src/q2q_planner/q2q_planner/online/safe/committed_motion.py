"""Committed motion of a swarm, propagated from tick to tick."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from q2q_model.signals.values import Array, Names, SwarmSetpoint, index_of
from q2q_planner.online.safe.braking import Motions, motion_after

Mask = NDArray[np.bool_]

LONGEST_GAP = 5.0
"""Gap between stamps after which vehicles restart on the reference [s]."""
SNAP_POS, SNAP_VEL = 1e-4, 5e-3
"""Distance [m] and speed [m/s] at which a vehicle snaps onto its reference; added to every zone's growth."""


@dataclass(frozen=True, slots=True)
class CommittedMotion:
    """Motion of every vehicle from t on: acc for hold, then braking."""

    t: float
    names: Names
    pos: Array
    """Modified position at t [m], (n, 3)."""
    vel: Array
    """[m/s], (n, 3)"""
    acc: Array
    """Held acceleration [m/s^2], (n, 3)."""
    hold: Array
    """Remaining hold time [s], (n,)."""
    on_reference: Mask
    """Exactly on its reference, (n,)."""
    pushed: Mask
    """Deviates from its wanted acceleration, (n,)."""


def at_reference(setpoint: SwarmSetpoint) -> CommittedMotion:
    """Return the motion of a swarm that starts on its reference."""
    n = len(setpoint.names)
    on, off = np.ones(n, np.bool_), np.zeros(n, np.bool_)
    start = setpoint.t, setpoint.names, setpoint.pos, setpoint.vel
    return CommittedMotion(*start, np.zeros((n, 3)), np.zeros(n), on, off)


def propagated(committed: CommittedMotion | None, setpoint: SwarmSetpoint, brake: float) -> CommittedMotion:
    """Return the motion at the setpoint's stamp; new vehicles, or all after a gap, start on the reference."""
    if committed is None or not 0.0 < setpoint.t - committed.t <= LONGEST_GAP:
        return at_reference(setpoint)
    passed = round(setpoint.t - committed.t, 9)  # stamps are whole nanoseconds
    motions = Motions(
        committed.pos, committed.vel, committed.acc, committed.hold, np.zeros((len(committed.names), 2))
    )
    pos, vel = motion_after(motions, passed, brake)
    left = np.maximum(committed.hold - passed, 0.0)
    if committed.names == setpoint.names:
        return CommittedMotion(
            setpoint.t,
            committed.names,
            pos,
            vel,
            committed.acc,
            left,
            committed.on_reference,
            committed.pushed,
        )
    fresh = at_reference(setpoint)
    rows = index_of(setpoint.names, committed.names)
    known = rows >= 0
    col = known[:, None]
    return CommittedMotion(
        setpoint.t,
        setpoint.names,
        np.where(col, pos[rows], fresh.pos),
        np.where(col, vel[rows], fresh.vel),
        np.where(col, committed.acc[rows], 0.0),
        np.where(known, left[rows], 0.0),
        committed.on_reference[rows] | ~known,
        committed.pushed[rows] & known,
    )


def near_reference(committed: CommittedMotion, setpoint: SwarmSetpoint) -> Mask:
    """Return which vehicles may snap onto their reference: near it and not pushed, (n,)."""
    pos = np.sqrt(((committed.pos - setpoint.pos) ** 2).sum(-1)) <= SNAP_POS
    vel = np.sqrt(((committed.vel - setpoint.vel) ** 2).sum(-1)) <= SNAP_VEL
    return np.asarray(~committed.pushed & pos & vel)
