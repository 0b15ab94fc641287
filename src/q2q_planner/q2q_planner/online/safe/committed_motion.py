"""Committed motion of a swarm, propagated from tick to tick."""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array, Mask, Names, SwarmSetpoint, rows_by_name
from q2q_planner.online.replanner import LONGEST_GAP
from q2q_planner.online.safe.safe_replanner_params import SafeReplannerParams
from q2q_planner.online.safe.stopping.braking import BrakingLaw, Motions, motions_after
from q2q_planner.online.safe.stopping.jerk_limited import jerk_limited_motion_after

SNAP_POS, SNAP_VEL = 1e-4, 5e-3
"""Distance [m] and speed [m/s] at which a vehicle snaps onto its reference; added to every zone's growth."""
ROUNDING = 1e-9
"""Of a change of acceleration at exactly the largest jerk [m/s^2]."""


class MotionRows(NamedTuple):
    """Committed motion of n vehicles: acc, or where it is bounded jerk, for hold; then braking."""

    pos: Array
    """Modified position [m], (n, 3)."""
    vel: Array
    """[m/s], (n, 3)."""
    acc: Array
    """Held acceleration, or where jerk is bounded that at the start [m/s^2], (n, 3)."""
    hold: Array
    """Remaining hold time [s], (n,)."""
    on_reference: Mask
    """Exactly on its reference, (n,)."""
    pushed: Mask
    """Deviates from its wanted acceleration, (n,)."""
    jerk: Array
    """Held jerk [m/s^3], (n, 3); 0 where it is not bounded."""


class ReferenceRows(NamedTuple):
    """Reference of n vehicles at a tick."""

    pos: Array
    """[m], (n, 3)."""
    vel: Array
    """[m/s], (n, 3)."""
    acc: Array
    """[m/s^2], (n, 3)."""


class FollowBounds(NamedTuple):
    """Bounds that a reference must keep to be followed."""

    jerk: float
    """Of an axis [m/s^3]."""
    passed: float
    """Time since the tick before, at most `hold` [s]."""
    acc: float
    """[m/s^2]."""
    speed: float
    """[m/s]."""
    lag: float
    """Of the acceleration, which is taken back [s]."""


@dataclass(frozen=True, slots=True)
class CommittedMotion:
    """Motion of every vehicle from t [s] on."""

    t: float
    names: Names
    rows: MotionRows
    passed: float = 0.0
    """Time since the tick before [s]."""


def at_reference(setpoint: SwarmSetpoint) -> CommittedMotion:
    """Return the motion of a swarm that starts on its reference."""
    n = len(setpoint.names)
    on, off = np.ones(n, np.bool_), np.zeros(n, np.bool_)
    rows = MotionRows(*reference_rows(setpoint), np.zeros(n), on, off, np.zeros((n, 3)))
    return CommittedMotion(setpoint.t, setpoint.names, rows)


def starting(setpoint: SwarmSetpoint, params: SafeReplannerParams) -> CommittedMotion:
    """Return the motion of a swarm that starts on its reference, or off one that exceeds the bounds.

    Such a vehicle of bounded jerk starts at most at speed_max, and without acceleration.
    """
    start = at_reference(setpoint)
    if params.jerk_max == 0.0:
        return start
    rows = start.rows
    on = followed_rows(rows, reference_rows(setpoint), follow_bounds(params, 0.0))
    vel, acc = up_to(rows.vel, params.speed_max), np.where(on[:, None], rows.acc, 0.0)
    return replace(start, rows=rows._replace(vel=vel, acc=acc, on_reference=on))


def up_to(vel: Array, speed: float) -> Array:
    """Return velocities (n, 3), those that are longer shortened to a speed [m/s], no more by rounding."""
    size = np.linalg.norm(vel, axis=1, keepdims=True)
    return np.where(size > speed, vel * ((1.0 - ROUNDING) * speed / np.maximum(size, speed)), vel)


def still_flown(committed: CommittedMotion | None, t: float) -> CommittedMotion | None:
    """Return the motion of the last tick; None where there is none, of no vehicle, or a gap since."""
    if committed is None or not committed.names or abs(t - committed.t) > LONGEST_GAP:
        return None
    return committed


def propagate(
    committed: CommittedMotion | None, setpoint: SwarmSetpoint, params: SafeReplannerParams
) -> CommittedMotion:
    """Return the motion at the setpoint's stamp; new vehicles start on the reference (`starting`).

    Where the stamp goes back, the motion waits for it: vehicles are where they were.

    Args:
        committed: motion of the last tick; None where all vehicles are new.
        setpoint: reference of this tick.
        params: bounds of braking, and of new vehicles.
    """
    if committed is None:
        return starting(setpoint, params)
    moved = _moved(committed, setpoint.t, params.acc_max, params.jerk_max)
    return moved if moved.names == setpoint.names else _with_new_vehicles(moved, setpoint, params)


def _moved(committed: CommittedMotion, t: float, brake: float, jerk: float) -> CommittedMotion:
    passed = round(max(t - committed.t, 0.0), 9)  # stamps are whole nanoseconds
    law = BrakingLaw(0.0, 0.0, brake, jerk)
    pos, vel, acc, hold = _carried(committed.rows, passed, law)
    rows = committed.rows._replace(pos=pos, vel=vel, acc=acc, hold=hold)
    return CommittedMotion(t, committed.names, rows, passed)


@compiled
def _carried(rows: MotionRows, passed: float, law: BrakingLaw) -> tuple[Array, Array, Array, Array]:
    """Return position, velocity, acceleration (n, 3) and remaining hold (n,) after a time [s]."""
    growth = np.zeros((rows.hold.size, 2))
    motions = Motions(rows.pos, rows.vel, rows.acc, rows.hold, growth, rows.jerk)
    left = np.maximum(rows.hold - passed, 0.0)
    if law.jerk > 0.0:
        pos, vel, acc = jerk_limited_motion_after(motions, passed, law)
        return pos, vel, acc, left
    pos, vel = motions_after(motions, np.full(rows.hold.size, passed), law.brake)
    return pos, vel, rows.acc.copy(), left


def _with_new_vehicles(
    moved: CommittedMotion, setpoint: SwarmSetpoint, params: SafeReplannerParams
) -> CommittedMotion:
    """Return the motion of the setpoint's vehicles; those that are new start on the reference."""
    pairs = zip(moved.rows, starting(setpoint, params).rows, strict=True)
    rows = MotionRows._make(rows_by_name(had, moved.names, setpoint.names, new) for had, new in pairs)
    return CommittedMotion(setpoint.t, setpoint.names, rows, moved.passed)


def reference_rows(setpoint: SwarmSetpoint) -> ReferenceRows:
    """Return the reference's arrays, of one layout whether they come from a plan or a message."""
    return ReferenceRows(np.array(setpoint.pos), np.array(setpoint.vel), np.array(setpoint.acc))


def follow_bounds(params: SafeReplannerParams, passed: float) -> FollowBounds:
    """Return the bounds of a reference, `passed` [s] after the tick before."""
    return FollowBounds(
        params.jerk_max, min(passed, params.hold), params.acc_max, params.speed_max, params.lag
    )


@compiled
def length(x: float, y: float, z: float) -> float:
    """Return the length of a vector."""
    return float(np.sqrt(x * x + y * y + z * z))


@compiled
def distance(some: Array, other: Array, row: int) -> float:
    """Return the distance of a row of two arrays (n, 3)."""
    return length(some[row, 0] - other[row, 0], some[row, 1] - other[row, 1], some[row, 2] - other[row, 2])


@compiled
def near_rows(rows: MotionRows, reference: ReferenceRows) -> Mask:
    """Return which vehicles may snap onto their reference: near it and not pushed, (n,)."""
    near = np.empty(rows.hold.size, np.bool_)
    for row in range(near.size):
        pos, vel = distance(rows.pos, reference.pos, row), distance(rows.vel, reference.vel, row)
        near[row] = not rows.pushed[row] and pos <= SNAP_POS and vel <= SNAP_VEL
    return near


@compiled
def followed_rows(rows: MotionRows, reference: ReferenceRows, bounds: FollowBounds) -> Mask:
    """Return whose reference keeps the bounds of jerk, acceleration and speed at this tick, (n,).

    An acceleration keeps the bound of jerk if it changed by no more than that within the time since the tick
    before, or within `hold` if that was longer ago. A speed keeps its bound if it still does once the
    acceleration is taken back.
    """
    followed = np.empty(rows.hold.size, np.bool_)
    jump = bounds.jerk * bounds.passed + ROUNDING
    acc = reference.acc
    for row in range(followed.size):
        size = length(acc[row, 0], acc[row, 1], acc[row, 2])
        followed[row] = size <= bounds.acc and _speed_ahead(reference, row, bounds) <= bounds.speed
        for axis in range(3):
            followed[row] &= abs(acc[row, axis] - rows.acc[row, axis]) <= jump
    return followed


@compiled
def _speed_ahead(reference: ReferenceRows, row: int, bounds: FollowBounds) -> float:
    """Return the speed that a row reaches if its acceleration is taken back from now on [m/s]."""
    vel, acc = reference.vel[row], reference.acc[row]
    speed = length(vel[0], vel[1], vel[2])
    rise = vel[0] * acc[0] + vel[1] * acc[1] + vel[2] * acc[2]
    if rise <= 0.0:
        return speed
    rise /= speed
    return float(speed + rise * (bounds.lag + 0.5 * rise / bounds.jerk))
