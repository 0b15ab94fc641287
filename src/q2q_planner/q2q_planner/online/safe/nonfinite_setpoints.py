"""Setpoints that are not finite: their vehicles brake, and no motion of another is computed from them.

| vehicle without a finite setpoint | what it flies |
|---|---|
| with a committed motion | it brakes on it and hovers |
| without | its setpoint as given; the others keep out of its way as an external one, if it is measured |

Both are PROMISE_BROKEN. A committed motion that is not finite, as from numbers that overflow, is dropped: its
vehicle is a new one.
"""

from dataclasses import dataclass, replace
from math import isfinite

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.signals.some_vehicles import of_vehicles
from q2q_model.signals.values import Array, Mask, SetpointStatus, SwarmSetpoint, index_of, rows_by_name
from q2q_planner.online.finite_setpoints import nonfinite_rows
from q2q_planner.online.safe.motion.committed_motion import CommittedMotion, MotionRows
from q2q_planner.online.safe.motion.followed_reference import ReferenceRows


@dataclass(frozen=True, slots=True)
class Flyable:
    """What a tick can be computed from."""

    setpoint: SwarmSetpoint
    """Setpoints that are finite, or hover; without the other vehicles."""
    committed: CommittedMotion | None
    """Motion that is finite."""


def is_flyable(setpoint: SwarmSetpoint, reference: ReferenceRows, committed: CommittedMotion | None) -> bool:
    """Return whether a tick can be computed from a setpoint as it is; `reference` is its motion."""
    turn = float(setpoint.yaw.sum() + setpoint.yaw_rate.sum())
    return is_finite(reference) and isfinite(turn) and moves_finitely(committed)


@compiled
def is_finite(rows: ReferenceRows) -> bool:
    """Return whether all numbers are finite; false, too, for finite ones whose sum is not."""
    total = 0.0
    for row in range(len(rows.pos)):
        for axis in range(3):
            total += rows.pos[row, axis] + rows.vel[row, axis] + rows.acc[row, axis]
    return bool(np.isfinite(total))


def moves_finitely(committed: CommittedMotion | None) -> bool:
    """Return whether a committed motion is finite; true if there is none."""
    if committed is None:
        return True
    rows = committed.rows
    return is_finite(ReferenceRows(rows.pos, rows.vel, rows.acc))


def flyable_inputs(
    given: SwarmSetpoint, committed: CommittedMotion | None, last: SwarmSetpoint | None
) -> Flyable:
    """Return what a tick can be computed from; `last` is the last output, whose yaw a hover keeps."""
    motion = _finite_motion(committed)
    moving = () if motion is None else motion.names
    rows, bad = index_of(given.names, moving), nonfinite_rows(given)
    hover, setpoint = bad & (rows >= 0), given
    if motion is not None and last is not None and hover.any():
        setpoint = _hovering(setpoint, hover, motion.rows.pos[rows], last)
    some = of_vehicles(setpoint, np.flatnonzero(~bad | hover))
    return Flyable(some, off_reference(motion, given))


def off_reference(committed: CommittedMotion | None, given: SwarmSetpoint) -> CommittedMotion | None:
    """Return the motion in which vehicles without finite setpoints are off their references.

    One on its reference jumps with it.
    """
    if committed is None:
        return None
    bad = rows_by_name(nonfinite_rows(given), given.names, committed.names)
    rows = committed.rows
    return committed.with_rows(rows._replace(on_reference=rows.on_reference & ~bad))


def output_for_all(given: SwarmSetpoint, output: SwarmSetpoint) -> SwarmSetpoint:
    """Return the output for all vehicles given; those without finite setpoints broke the promise."""
    have, names = output.names, given.names
    status = rows_by_name(output.status, have, names, SetpointStatus.PROMISE_BROKEN)
    status[nonfinite_rows(given)] = SetpointStatus.PROMISE_BROKEN
    return SwarmSetpoint(
        given.t,
        names,
        rows_by_name(output.pos, have, names, given.pos),
        rows_by_name(output.vel, have, names, given.vel),
        rows_by_name(output.acc, have, names, given.acc),
        rows_by_name(output.yaw, have, names, given.yaw),
        rows_by_name(output.yaw_rate, have, names, given.yaw_rate),
        status,
    )


def _finite_motion(committed: CommittedMotion | None) -> CommittedMotion | None:
    if committed is None:
        return None
    rows = committed.rows
    kept = np.asarray(np.isfinite(np.column_stack([rows.pos, rows.vel, rows.acc])).all(axis=1))
    names = tuple(name for name, stays in zip(committed.names, kept, strict=True) if stays)
    return CommittedMotion(committed.t, names, MotionRows._make(field[kept] for field in rows))


def _hovering(setpoint: SwarmSetpoint, hover: Mask, pos: Array, last: SwarmSetpoint) -> SwarmSetpoint:
    """Return the setpoint in which `hover` vehicles, (n,), rest at pos (n, 3) with the yaw that they have."""
    col, yaw = hover[:, None], last.yaw[index_of(setpoint.names, last.names)]
    turns = hover & ~np.isfinite(setpoint.yaw + setpoint.yaw_rate)
    return replace(
        setpoint,
        pos=np.where(col, pos, setpoint.pos),
        vel=np.where(col, 0.0, setpoint.vel),
        acc=np.where(col, 0.0, setpoint.acc),
        yaw=np.where(turns, yaw, setpoint.yaw),
        yaw_rate=np.where(turns, 0.0, setpoint.yaw_rate),
    )
