"""Reference of a tick: who may snap onto it, and who may follow it within the bounds.

A vehicle near its reference snaps onto it. Where jerk is bounded it does so, and stays there, only while the
reference itself keeps the bounds of jerk, acceleration and speed.
"""

from typing import NamedTuple

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array, Mask, SwarmSetpoint
from q2q_planner.online.safe.motion.committed_motion import MotionRows
from q2q_planner.online.safe.motion.safe_replanner_params import SafeReplannerParams
from q2q_planner.online.safe.motion.vectors import distance, length, norm
from q2q_planner.online.safe.stopping.jerk_limited import speed_bound

SNAP_POS, SNAP_VEL = 1e-4, 5e-3
"""Distance [m] and speed [m/s] at which a vehicle snaps onto its reference; added to every zone's growth."""
ROUNDING = 1e-9
"""Of a change of acceleration at exactly the largest jerk [m/s^2]."""


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
    dt: float
    """Time since the tick before, at most `hold` [s]."""
    acc: float
    """[m/s^2]."""
    speed: float
    """[m/s]."""
    lag: float
    """Of the acceleration, which is taken back [s]."""
    hold: float
    """Time for which it is held at least [s]."""


def reference_rows(setpoint: SwarmSetpoint) -> ReferenceRows:
    """Return the reference's arrays, of one layout whether they come from a plan or a message."""
    return ReferenceRows(np.array(setpoint.pos), np.array(setpoint.vel), np.array(setpoint.acc))


def follow_bounds(params: SafeReplannerParams, dt: float) -> FollowBounds:
    """Return the bounds of a reference, `dt` [s] after the tick before."""
    most = params.acc_max, params.speed_max
    return FollowBounds(params.jerk_max, min(dt, params.hold), *most, params.lag, params.hold)


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

    An acceleration keeps the bound of jerk if it differs by no more than that from the motion's at the tick
    before, within the time since then, or within `hold` if that was longer ago. A speed keeps its bound if it
    still does once the acceleration is taken back, and on the fastest stop after `hold`, the motion to which
    it leads.
    """
    followed = np.empty(rows.hold.size, np.bool_)
    jump = bounds.jerk * bounds.dt + ROUNDING
    acc, steady, held = reference.acc, np.zeros_like(reference.acc), (bounds.hold, bounds.jerk)
    for row in range(followed.size):
        size = length(acc[row, 0], acc[row, 1], acc[row, 2])
        followed[row] = size <= bounds.acc and _speed_ahead(reference, row, bounds) <= bounds.speed
        followed[row] &= speed_bound(reference.vel, acc, steady, row, held) <= bounds.speed
        for axis in range(3):
            before = rows.acc[row, axis] - rows.jerk[row, axis] * bounds.dt
            followed[row] &= abs(acc[row, axis] - before) <= jump
    return followed


@compiled
def _speed_ahead(reference: ReferenceRows, row: int, bounds: FollowBounds) -> float:
    """Return the speed that a row reaches if its acceleration is taken back from now on [m/s]."""
    vel, acc = reference.vel[row], reference.acc[row]
    speed = norm(vel)
    rise = vel[0] * acc[0] + vel[1] * acc[1] + vel[2] * acc[2]
    if rise <= 0.0:
        return speed
    rise /= speed
    return float(speed + rise * (bounds.lag + 0.5 * rise / bounds.jerk))
