"""Reach of a vehicle: plans of the high-level commander that it cannot follow even at full thrust.

A vehicle that is at p with velocity v, whose thrust has any direction and at most F/m, is after T within the
ball

    |p' - p - v T + g T^2 / 2 e_z| <= F/m T^2 / 2

so that a piece whose end is outside leaves the vehicle behind by the difference at least, whatever the
controller. Between two pieces T is 0: a trajectory must not jump, nor begin away from the goal before it. A
plan of 0 s or less is its end at once, but that of a line or a spiral, whose speeds are infinite, has none.
"""

from itertools import pairwise
from math import isfinite

import numpy as np

from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import GRAVITY, Vehicle
from q2q_sim.firmware.commander.piecewise import Piecewise
from q2q_sim.firmware.commander.polynomial import Piece, goal_at

BEHIND = 0.15
"""Distance by which a plan may leave a vehicle behind [m]: just more than CONTACT, at which two touch."""


def reach_violation(plan: Piecewise, here: Array, vehicle: Vehicle) -> str:
    """Return what of a plan is out of reach; empty if nothing is.

    Args:
        plan: begun.
        here: goal before it, or the vehicle's position if there was none [m], world, (3,).
        vehicle: that is to follow.
    """
    jump = max((_jump(one, other) for one, other in pairwise(plan.pieces)), default=0.0)
    if jump > BEHIND:
        return f"a trajectory that jumps by {jump:.2f} m between two pieces"
    away = _away(plan, here)
    if not isfinite(away):
        return "a position that is not finite, like that of a line or spiral in 0 s: it drops the plan"
    if plan.duration > 0.0 and away > BEHIND:
        return f"a trajectory that begins {away:.2f} m from its position"
    behind = _behind(plan, here, vehicle)
    return f"a position {behind:.2f} m beyond the reach of full thrust in that time" if behind else ""


def _behind(plan: Piecewise, here: Array, vehicle: Vehicle) -> float:
    """Return by how much a plan leaves a vehicle behind first [m]; 0 if by no more than BEHIND."""
    if plan.duration <= 0.0:
        behind = [_away(plan, here)]
    elif plan.backwards:
        behind = []
    else:
        behind = [distance_beyond_reach(piece, plan.timescale, vehicle) for piece in plan.pieces]
    return next((one for one in behind if one > BEHIND), 0.0)


def _away(plan: Piecewise, here: Array) -> float:
    """Return the distance from a place to the begin of a plan [m]."""
    return float(np.linalg.norm(plan.goal(plan.begin).pos - here))


def distance_beyond_reach(piece: Piece, timescale: float, vehicle: Vehicle) -> float:
    """Return how far the end of a piece is beyond a vehicle's reach from its start [m]; below 0 within."""
    T = piece.duration * timescale
    if not T > 0.0:
        return 0.0
    start, end = goal_at(piece, 0.0), goal_at(piece, piece.duration)
    fall = np.array([0.0, 0.0, 0.5 * GRAVITY * T**2])
    away = end.pos - start.pos - start.vel * piece.duration + fall
    return float(np.linalg.norm(away)) - 0.5 * vehicle.thrust_max / vehicle.mass * T**2


def _jump(one: Piece, other: Piece) -> float:
    """Return the distance from the end of a piece to the start of the next one [m]."""
    return float(np.linalg.norm(goal_at(other, 0.0).pos - goal_at(one, one.duration).pos))
