"""Planes of the walls: rows of the convex step that keep single vehicles within a room.

A wall is its own plane at every sample. Only samples that are beyond it, the deepest of each run, and those
whose plane was touched before get a row, so that rows stay few. Rows are numbered 6 vehicle + wall, in the
order of `Walls.distances`.
"""

from typing import NamedTuple

import numpy as np

from q2q_model.signals.values import Array, Mask, Rows
from q2q_planner.offline.avoidance.near_samples import deepest_of_runs
from q2q_planner.offline.avoidance.separating_planes import Planes
from q2q_planner.offline.walls import WALLS, Walls


class WallWatch(NamedTuple):
    """Samples of vehicles that are beyond a wall, or were."""

    row: Rows
    """6 vehicle + wall, (w,)."""
    sample: Rows
    """(w,)"""
    distance: float
    """Minimum distance of any vehicle to a wall at any sample [m]."""


def watch_walls(positions: Array, walls: Walls, watched: Mask, *, nearest: bool) -> WallWatch:
    """Return the samples to give planes, and those `watched` already, (6 n, S); positions are (S, n, 3).

    If there are none, a wall may still be crossed between samples: `nearest` then asks for the nearest one.
    """
    distance = walls.distances(positions).reshape(len(positions), -1).T  # (6 n, S)
    wanted = watched.copy()
    for beyond in np.flatnonzero((distance < 0.0).any(axis=1)):
        inside = np.flatnonzero(distance[beyond] < 0.0)
        wanted[beyond, deepest_of_runs(inside, -distance[beyond, inside])] = True
    if nearest and not wanted.any():
        wanted.flat[distance.argmin()] = True
    row, sample = np.nonzero(wanted)
    return WallWatch(row, sample, float(distance.min()))


def wall_planes(watch: WallWatch, walls: Walls, margin: float, static: int) -> Planes:
    """Return a plane each, `margin` [m] inside its wall; `static` is the vehicle that stands for the room."""
    vehicle, wall = np.divmod(watch.row, WALLS)
    normal = np.concatenate([np.eye(3), -np.eye(3)])
    level = np.concatenate([walls.low, np.negative(walls.high)]) + margin
    return Planes(vehicle, np.full_like(vehicle, static), watch.sample, normal[wall], level[wall])


def join_planes(one: Planes, other: Planes) -> Planes:
    """Return the planes of both."""
    return Planes(
        np.concatenate([one.first, other.first]),
        np.concatenate([one.second, other.second]),
        np.concatenate([one.sample, other.sample]),
        np.concatenate([one.normal, other.normal]),
        np.concatenate([one.level, other.level]),
    )
