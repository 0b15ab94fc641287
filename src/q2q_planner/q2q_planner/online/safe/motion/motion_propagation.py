"""Committed motion propagated from tick to tick; a new vehicle's motion starts on its reference."""

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array, SwarmSetpoint, rows_by_name
from q2q_planner.online.safe.motion.committed_motion import CommittedMotion, MotionRows
from q2q_planner.online.safe.motion.followed_reference import (
    ROUNDING,
    follow_bounds,
    followed_rows,
    reference_rows,
)
from q2q_planner.online.safe.motion.safe_replanner_params import SafeReplannerParams
from q2q_planner.online.safe.stopping.braking import BrakingLaw, Motions, motions_after
from q2q_planner.online.safe.stopping.jerk_limited import jerk_limited_motion_after


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
    dt = round(max(t - committed.t, 0.0), 9)  # stamps are whole nanoseconds
    law = BrakingLaw(0.0, 0.0, brake, jerk)
    pos, vel, acc, hold = _carried(committed.rows, dt, law)
    rows = committed.rows._replace(pos=pos, vel=vel, acc=acc, hold=hold)
    return CommittedMotion(t, committed.names, rows, dt)


@compiled
def _carried(rows: MotionRows, dt: float, law: BrakingLaw) -> tuple[Array, Array, Array, Array]:
    """Return position, velocity, acceleration (n, 3) and remaining hold (n,) after a time [s]."""
    growth = np.zeros((rows.hold.size, 2))
    motions = Motions(rows.pos, rows.vel, rows.acc, rows.hold, growth, rows.jerk)
    left = np.maximum(rows.hold - dt, 0.0)
    if law.jerk > 0.0:
        pos, vel, acc = jerk_limited_motion_after(motions, dt, law)
        return pos, vel, acc, left
    pos, vel = motions_after(motions, np.full(rows.hold.size, dt), law.brake)
    return pos, vel, rows.acc.copy(), left


def _with_new_vehicles(
    moved: CommittedMotion, setpoint: SwarmSetpoint, params: SafeReplannerParams
) -> CommittedMotion:
    """Return the motion of the setpoint's vehicles; those that are new start on the reference."""
    pairs = zip(moved.rows, starting(setpoint, params).rows, strict=True)
    rows = MotionRows._make(rows_by_name(had, moved.names, setpoint.names, new) for had, new in pairs)
    return CommittedMotion(setpoint.t, setpoint.names, rows, moved.dt)


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
    return start.with_rows(rows._replace(vel=vel, acc=acc, on_reference=on))


def up_to(vel: Array, speed: float) -> Array:
    """Return velocities (n, 3), those that are longer shortened to a speed [m/s], no more by rounding."""
    size = np.linalg.norm(vel, axis=1, keepdims=True)
    return np.where(size > speed, vel * ((1.0 - ROUNDING) * speed / np.maximum(size, speed)), vel)
