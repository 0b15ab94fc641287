"""Parameters of the avoidance of zones (q2q_planner.offline.avoidance.joint_plan)."""

from dataclasses import dataclass
from math import isfinite

from q2q_model.tunable import check_bounds, tunable
from q2q_planner.offline.walls import Walls


@dataclass(frozen=True, slots=True)
class AvoidanceParams:
    """Parameters of the search; none of them weakens the proof."""

    pieces: int = tunable(5, "pieces between two waypoints; more give a freer curve", low=2, high=40)
    margin: float = tunable(2e-4, "distance kept from the zone", unit="m", low=1e-6, high=1.0)
    steps: int = tunable(40, "most convex steps from one start", low=1, high=1000)
    initial_guesses: int = tunable(
        2, "initial guesses tried: as the pairs pass, mirrored, then at random", low=1, high=100
    )
    seed: int = tunable(0, "seed of the random initial guesses", low=0)
    within: tuple[float, ...] = tunable(
        (), "box that all vehicles stay within: smallest x, y, z, largest x, y, z; none if empty", unit="m"
    )

    def __post_init__(self) -> None:
        """Raise ValueError if a number is out of bounds, or `within` is no box."""
        if not all(map(isfinite, self.within)):
            raise ValueError(f"AvoidanceParams.within = {self.within}; must be finite numbers")
        check_bounds(self)
        if self.walls is None and self.within:
            raise ValueError(f"AvoidanceParams.within has {len(self.within)} numbers; must have 6 or none")

    @property
    def walls(self) -> Walls | None:
        """Return the box of `within`, or None."""
        if len(self.within) != 6:
            return None
        x, y, z, far_x, far_y, far_z = self.within
        return Walls((x, y, z), (far_x, far_y, far_z))
