"""Trajectories of a swarm on common pieces, so that vehicles can be compared piece by piece."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import comb

import numpy as np

from q2q_model.signals.values import Array
from q2q_model.trajectory.polynomials import Trajectory

SAME_TIME = 1e-9
"""Cuts closer than this are one [s]: the rounding of summed durations."""


@dataclass(frozen=True, slots=True, eq=False)
class SharedPieces:
    """Positions of n vehicles on common pieces."""

    starts: Array
    """Start of each piece [s], (pieces,)."""
    durations: Array
    """Length of each piece [s], (pieces,)."""
    coefficients: Array
    """Ascending powers of the time since the piece's start, (pieces, n, 3, order)."""


def split_at(trajectory: Trajectory, cuts: Array) -> Trajectory:
    """Return the same curve with pieces that also end at `cuts` (k,) [s]; at rest beyond its end."""
    ends = np.cumsum(trajectory.durations)
    times = _merged(np.concatenate([[0.0], ends, cuts]))
    starts, durations = times[:-1], np.diff(times)
    piece = np.minimum(np.searchsorted(ends, starts + SAME_TIME, side="right"), len(ends) - 1)
    rests = starts > ends[-1] - SAME_TIME
    ahead = np.where(rests, trajectory.durations[-1], starts - (ends - trajectory.durations)[piece])
    moved = _shifted(trajectory.coefficients[piece], np.maximum(ahead, 0.0))
    moved[rests, :, 1:] = 0.0
    return Trajectory(durations, moved)


def shared_pieces(trajectories: Sequence[Trajectory]) -> SharedPieces:
    """Return the positions of all vehicles on the union of their pieces."""
    cuts = common_cuts(trajectories)
    order = max(trajectory.coefficients.shape[-1] for trajectory in trajectories)
    aligned = np.zeros((len(cuts) - 1, len(trajectories), 3, order))
    for row, trajectory in enumerate(trajectories):
        pieces = split_at(trajectory, cuts).coefficients[:, :3]
        aligned[:, row, :, : pieces.shape[-1]] = pieces
    return SharedPieces(cuts[:-1], np.diff(cuts), aligned)


def common_cuts(trajectories: Sequence[Trajectory]) -> Array:
    """Return 0 and the times (k,) [s] at which any piece ends, rising, more than SAME_TIME apart."""
    ends = [np.cumsum(trajectory.durations) for trajectory in trajectories]
    return _merged(np.concatenate([[0.0], *ends]))


def _merged(times: Array) -> Array:
    rising = np.unique(times)
    return np.asarray(rising[np.concatenate([[True], np.diff(rising) > SAME_TIME])])


def _shifted(coefficients: Array, ahead: Array) -> Array:
    """Return p(t + ahead) as powers of t: c'_k = sum_{i >= k} C(i, k) ahead^(i - k) c_i."""
    order = coefficients.shape[-1]
    moved = np.zeros_like(coefficients)
    for k in range(order):
        for i in range(k, order):
            moved[..., k] += comb(i, k) * ahead[:, None] ** (i - k) * coefficients[..., i]
    return moved
