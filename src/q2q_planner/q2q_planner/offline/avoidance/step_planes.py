"""Planes of one convex step: of pairs near the zone, and of vehicles beyond the walls.

The planes of a sample are numbered by rows: first the pairs, then the walls of the vehicles.
"""

from dataclasses import dataclass

import numpy as np

from q2q_model.signals.values import Array, Mask, Rows
from q2q_planner.offline.avoidance.avoidance_problem import Problem
from q2q_planner.offline.avoidance.near_samples import cut_corners
from q2q_planner.offline.avoidance.separating_planes import Planes, Sides, Watch, planes_of, watch_pairs
from q2q_planner.offline.avoidance.wall_planes import WallWatch, join_planes, wall_planes, watch_walls


@dataclass(frozen=True, slots=True, eq=False)
class WatchedSamples:
    """Samples that get planes."""

    pairs: Watch
    walls: WallWatch | None
    """None without walls."""

    @property
    def distance(self) -> float:
        """Return the smallest distance of a watched sample to zone or wall [m]; negative if violated."""
        apart = float(self.pairs.distance.min(initial=0.0))
        return apart if self.walls is None else min(apart, self.walls.distance)

    def planes(self, problem: Problem, sides: Sides) -> tuple[tuple[Rows, Rows], Planes]:
        """Return (row, sample) of each plane, and the planes."""
        seen = self.pairs
        made = planes_of(seen, problem.pairs, problem.zone, problem.margin, sides)
        if self.walls is None or problem.walls is None:
            return (seen.pair, seen.sample), made
        row = np.concatenate([seen.pair, len(problem.pairs[0]) + self.walls.row])
        sample = np.concatenate([seen.sample, self.walls.sample])
        added = wall_planes(self.walls, problem.walls, problem.margin, static=len(problem.spaces))
        return (row, sample), join_planes(made, added)


def watched_samples(problem: Problem, positions: Array, touched: Mask, *, corners: bool) -> WatchedSamples:
    """Return the samples that get planes in the next step.

    Args:
        problem: zone and walls.
        positions: of all vehicles at all samples [m], (S, n, 3).
        touched: planes that the last step touched, (rows, S).
        corners: whether the deepest sample of each pass through the zone is among them.
    """
    count = len(problem.pairs[0])
    watched = touched[:count]
    if corners:
        watched = watched | cut_corners(positions, problem.pairs, problem.zone)
    pairs = watch_pairs(positions, problem.pairs, problem.zone, watched)
    if problem.walls is None:
        return WatchedSamples(pairs, None)
    alone = not len(pairs.sample)
    return WatchedSamples(pairs, watch_walls(positions, problem.walls, touched[count:], nearest=alone))
