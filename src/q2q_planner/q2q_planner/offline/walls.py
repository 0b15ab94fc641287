"""Walls of a room, and the proof that no vehicle of a plan crosses one, at any time.

On a stretch of time the distance to a wall is a polynomial, and at least the least of its Bernstein control
points (`q2q_model.trajectory.bernstein`), which bound it in `branch_and_bound`. Rounding is taken off, as by
`certificate`.
"""

from dataclasses import dataclass
from math import inf

import numpy as np

from q2q_model.signals.values import Array, Three
from q2q_model.trajectory.bernstein import control_points
from q2q_model.trajectory.polynomials import SwarmPlan
from q2q_planner.offline.certificate.branch_and_bound import least_on_stretches, polynomial_bounds
from q2q_planner.offline.certificate.rounding_bound import MOST_ROUNDING, ROUNDING, rounding_slack
from q2q_planner.offline.certificate.shared_pieces import shared_pieces

WALLS = 6
"""Walls of a room: low x, y, z, high x, y, z."""


@dataclass(frozen=True, slots=True)
class Walls:
    """Box that all vehicles stay within."""

    low: Three
    """Minimum x, y, z [m], world."""
    high: Three
    """Largest x, y, z [m], world."""

    def __post_init__(self) -> None:
        """Raise ValueError unless each side is longer than zero, and finite."""
        if not all(-inf < low < high < inf for low, high in zip(self.low, self.high, strict=True)):
            words = f"x, y, z from {_words(self.low)} to {_words(self.high)}"
            raise ValueError(f"walls: {words}; must be finite and in increasing order")

    def distances(self, pos: Array) -> Array:
        """Return the distances to the six walls [m], (..., 6), of positions (..., 3): low x y z, high x y z.

        Negative beyond a wall.
        """
        return np.concatenate([pos - np.array(self.low), np.array(self.high) - pos], axis=-1)

    def __str__(self) -> str:
        """Return the box in words."""
        return f"within ({_words(self.low)}) to ({_words(self.high)}) m"


@dataclass(frozen=True, slots=True)
class WallProof:
    """Proven distance of a plan's vehicles to the walls."""

    clearance: float
    """Lower bound of every vehicle's distance to every wall at any t [m]; -infinite if rounding is above
    MOST_ROUNDING."""
    name: str
    """The vehicle that comes nearest."""
    t: float
    """Time of its smallest distance [s]."""
    walls: Walls

    @property
    def holds(self) -> bool:
        """Return whether the plan is proven to stay within the walls."""
        return self.clearance > ROUNDING


def prove_within(plan: SwarmPlan, walls: Walls) -> WallProof:
    """Return the proven distance of a plan to the walls."""
    rounding = rounding_slack(plan.trajectories)
    if not rounding < MOST_ROUNDING:
        return WallProof(-np.inf, plan.names[0], 0.0, walls)
    shared = shared_pieces(plan.trajectories)
    points = control_points(shared.coefficients, shared.durations[:, None, None])  # (pieces, n, 3, order)
    gaps = np.moveaxis(walls.distances(np.moveaxis(points, 2, -1)), -1, 2)  # (pieces, n, 6, order)
    found = least_on_stretches(gaps.reshape(-1, gaps.shape[-1]), polynomial_bounds)
    piece, vehicle, _ = np.unravel_index(found.row, gaps.shape[:-1])
    t = shared.starts[piece] + found.share * shared.durations[piece]
    return WallProof(found.bound - rounding, plan.names[int(vehicle)], float(t), walls)


def _words(point: Three) -> str:
    return " ".join(f"{value:g}" for value in point)
