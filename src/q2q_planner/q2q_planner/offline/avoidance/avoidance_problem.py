"""What a joint plan has to leave: the zone of every pair, and the walls of a room."""

from dataclasses import dataclass

import numpy as np

from q2q_model.signals.values import Rows
from q2q_model.trajectory.polynomials import SwarmPlan
from q2q_planner.offline.avoidance.deviation_space import DeviationSpace
from q2q_planner.offline.certificate.convex_zone import ConvexZone
from q2q_planner.offline.walls import WALLS, Walls


@dataclass(frozen=True, slots=True, eq=False)
class Problem:
    """Trajectories to deform and the zone they must leave."""

    free: SwarmPlan
    """Minimum snap without avoidance."""
    infimum: float
    """Its cost."""
    spaces: tuple[DeviationSpace, ...]
    """Deformations of each vehicle."""
    zone: ConvexZone
    margin: float
    """Distance kept from zone and walls [m]."""
    most_steps: int
    walls: Walls | None
    """None without."""

    @property
    def rows(self) -> int:
        """Return the number of pairs and of walls of vehicles, which may each have a plane in a sample."""
        return len(self.pairs[0]) + (WALLS * len(self.spaces) if self.walls else 0)

    @property
    def pairs(self) -> tuple[Rows, Rows]:
        """Return vehicles i and j of every pair, (pairs,) each."""
        return np.triu_indices(len(self.spaces), 1)
