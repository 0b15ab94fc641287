"""Committed motion of a swarm, propagated from tick to tick."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from q2q_model.signals.values import Array, Names, SwarmSetpoint, index_of
from q2q_planner.online.safe.braking import BrakingLaw, Motions, motion_after
from q2q_planner.online.safe.jerk_limited import smooth_motion_after
from q2q_planner.online.safe.safe_replanner_params import SafeReplannerParams

Mask = NDArray[np.bool_]

LONGEST_GAP = 5.0
"""Gap between stamps, forwards or back, after which vehicles restart on the reference [s]."""
SNAP_POS, SNAP_VEL = 1e-4, 5e-3
"""Distance [m] and speed [m/s] at which a vehicle snaps onto its reference; added to every zone's growth."""


@dataclass(frozen=True, slots=True)
class CommittedMotion:
    """Motion of every vehicle from t on: acc, or where it is bounded jerk, for hold; then braking."""

    t: float
    names: Names
    pos: Array
    """Modified position at t [m], (n, 3)."""
    vel: Array
    """[m/s], (n, 3)"""
    acc: Array
    """Held acceleration, or that at t where jerk is bounded [m/s^2], (n, 3)."""
    hold: Array
    """Remaining hold time [s], (n,)."""
    on_reference: Mask
    """Exactly on its reference, (n,)."""
    pushed: Mask
    """Deviates from its wanted acceleration, (n,)."""
    jerk: Array
    """Held jerk [m/s^3], (n, 3); 0 where it is not bounded."""


def at_reference(setpoint: SwarmSetpoint) -> CommittedMotion:
    """Return the motion of a swarm that starts on its reference."""
    n = len(setpoint.names)
    on, off = np.ones(n, np.bool_), np.zeros(n, np.bool_)
    start = setpoint.t, setpoint.names, setpoint.pos, setpoint.vel, setpoint.acc
    return CommittedMotion(*start, np.zeros(n), on, off, np.zeros((n, 3)))


def propagated(
    committed: CommittedMotion | None, setpoint: SwarmSetpoint, brake: float, jerk: float = 0.0
) -> CommittedMotion:
    """Return the motion at the setpoint's stamp; new vehicles, or all after a gap, start on the reference.

    Where the stamp goes back, the motion waits for it: vehicles are where they were.

    Args:
        committed: motion of the last tick.
        setpoint: reference of this tick.
        brake: deceleration to rest [m/s^2].
        jerk: bound of the jerk [m/s^3]; 0 for none.
    """
    if committed is None or abs(setpoint.t - committed.t) > LONGEST_GAP:
        return at_reference(setpoint)
    moved = _moved(committed, setpoint.t, brake, jerk)
    return moved if moved.names == setpoint.names else _with_new_vehicles(moved, setpoint)


def _moved(committed: CommittedMotion, t: float, brake: float, jerk: float) -> CommittedMotion:
    passed = round(max(t - committed.t, 0.0), 9)  # stamps are whole nanoseconds
    growth = np.zeros((len(committed.names), 2))
    motions = Motions(committed.pos, committed.vel, committed.acc, committed.hold, growth, committed.jerk)
    if jerk > 0.0:
        pos, vel, acc = smooth_motion_after(motions, passed, BrakingLaw(0.0, 0.0, brake, jerk))
    else:
        (pos, vel), acc = motion_after(motions, passed, brake), committed.acc
    left = np.maximum(committed.hold - passed, 0.0)
    return replace(committed, t=t, pos=pos, vel=vel, acc=acc, hold=left)


def _with_new_vehicles(moved: CommittedMotion, setpoint: SwarmSetpoint) -> CommittedMotion:
    """Return the motion of the setpoint's vehicles; those that are new start on the reference."""
    fresh = at_reference(setpoint)
    rows = index_of(setpoint.names, moved.names)
    known = rows >= 0
    col = known[:, None]
    return CommittedMotion(
        setpoint.t,
        setpoint.names,
        np.where(col, moved.pos[rows], fresh.pos),
        np.where(col, moved.vel[rows], fresh.vel),
        np.where(col, moved.acc[rows], fresh.acc),
        np.where(known, moved.hold[rows], 0.0),
        moved.on_reference[rows] | ~known,
        moved.pushed[rows] & known,
        np.where(col, moved.jerk[rows], 0.0),
    )


def near_reference(committed: CommittedMotion, setpoint: SwarmSetpoint) -> Mask:
    """Return which vehicles may snap onto their reference: near it and not pushed, (n,)."""
    pos = np.sqrt(((committed.pos - setpoint.pos) ** 2).sum(-1)) <= SNAP_POS
    vel = np.sqrt(((committed.vel - setpoint.vel) ** 2).sum(-1)) <= SNAP_VEL
    return np.asarray(~committed.pushed & pos & vel)


def can_be_followed(committed: CommittedMotion, setpoint: SwarmSetpoint, params: SafeReplannerParams) -> Mask:
    """Return whose reference keeps the bounds of jerk, acceleration and speed at this tick, (n,).

    An acceleration that jumps by no more than the jerk changes it within `hold` keeps that of the jerk.
    """
    jump = np.abs(setpoint.acc - committed.acc).max(-1, initial=0.0)
    size, speed = np.sqrt((setpoint.acc**2).sum(-1)), np.sqrt((setpoint.vel**2).sum(-1))
    steady = jump <= params.jerk_max * params.hold
    return np.asarray(steady & (size <= params.acc_max) & (speed <= params.speed_max))
