"""Steps of a reference from one piece to the next, and between its ends and the rest before and after.

Thrust and tilt are those of the acceleration inside the pieces, and a step of the velocity is an acceleration
outside all pieces. The acceleration and the yaw rate may step: bounds of them hold on both sides.
"""

from typing import NamedTuple

import numpy as np

from q2q_model.signals.values import Array
from q2q_model.trajectory.polynomials import Trajectory, derive

TURN = 2.0 * np.pi
"""Yaws that differ by it are one attitude [rad]."""


class Steps(NamedTuple):
    """Steps of a trajectory: the largest ones, or their largest sums."""

    pos: float
    """Of a coordinate, from one piece to the next [m]."""
    vel: float
    """Of a coordinate's rate, from one piece to the next or between an end and rest [m/s]."""
    yaw: float
    """From one piece to the next, less whole turns [rad]."""


class _TimedSteps(NamedTuple):
    """Sizes of the steps of one quantity."""

    t: Array
    """[s], rising, (k,)."""
    size: Array
    """Of each coordinate, (k, coordinates)."""


def largest_steps(curve: Trajectory) -> Steps:
    """Return the largest steps over all pieces; not finite where numbers overflow."""
    return Steps(*(float(one.size.max(initial=0.0)) for one in _all_steps(curve)))


def largest_step_sums(curve: Trajectory, span: float) -> Steps:
    """Return the largest sums of the steps within any `span` [s]; not finite where numbers overflow."""
    return Steps(*(_largest_sum(one, span) for one in _all_steps(curve)))


def _all_steps(curve: Trajectory) -> tuple[_TimedSteps, _TimedSteps, _TimedSteps]:
    """Return the steps of position, velocity and yaw."""
    starts, ends = _at_both_ends(curve, 0)
    rest = np.zeros((1, 3))
    start_vel, end_vel = (vel[:, :3] for vel in _at_both_ends(curve, 1))
    pos = ends[:-1, :3] - starts[1:, :3]
    vel = np.concatenate([rest, end_vel]) - np.concatenate([start_vel, rest])
    yaw = np.remainder(ends[:-1, 3:] - starts[1:, 3:] + 0.5 * TURN, TURN) - 0.5 * TURN
    t = np.concatenate([[0.0], np.cumsum(curve.durations)])
    return _TimedSteps(t[1:-1], np.abs(pos)), _TimedSteps(t, np.abs(vel)), _TimedSteps(t[1:-1], np.abs(yaw))


def _largest_sum(steps: _TimedSteps, span: float) -> float:
    """Return the largest sum, of a coordinate, of the steps within any `span` [s]."""
    total = np.concatenate([np.zeros((1, steps.size.shape[1])), np.cumsum(steps.size, axis=0)])
    last = np.searchsorted(steps.t, steps.t + span, side="right")
    return float((total[last] - total[:-1]).max(initial=0.0))


def _at_both_ends(curve: Trajectory, derivative: int) -> tuple[Array, Array]:
    """Return a derivative at the start and at the end of every piece, (pieces, 4) each."""
    derived = derive(curve.coefficients, derivative)
    powers = curve.durations[:, None, None] ** np.arange(derived.shape[-1])
    return derived[..., 0], (derived * powers).sum(-1)
