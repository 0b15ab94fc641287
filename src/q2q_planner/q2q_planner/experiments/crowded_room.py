"""Random swaps in a room: all vehicles leave their places at once for each other's, and cross in the middle.

Places are drawn uniformly, out of each other's zone; goals are a cyclic shift of them, which are in random
order. A room holds a swap if the joint plan is certified, out of the zones and within the walls, and the
vehicle has the thrust for it.
"""

from dataclasses import dataclass

import numpy as np

from q2q_model.geometry.zone import Zone
from q2q_model.signals.values import Array
from q2q_model.trajectory.polynomials import SwarmPlan
from q2q_model.tunable import check_bounds, tunable
from q2q_model.vehicle.constants import Vehicle
from q2q_planner.offline.avoidance.avoidance_params import AvoidanceParams
from q2q_planner.offline.avoidance.joint_plan import avoid_zones
from q2q_planner.offline.avoidance.waypoint_checks import InfeasibleError
from q2q_planner.offline.minimum_snap.feasibility import NotFlyableError, check_feasible
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, waypoints_through

DRAWS = 5000
"""Most draws of a place."""
CLEAR = 0.01
"""Distance of places from each other's zone [m]."""
STEPS = 20
"""Most convex steps of a plan."""


@dataclass(frozen=True, slots=True)
class RoomSize:
    """Room, with one corner of its floor at the origin."""

    length: float = tunable(3.0, "along x", unit="m", low=0.5, high=100.0)
    width: float = tunable(3.0, "along y", unit="m", low=0.5, high=100.0)
    height: float = tunable(2.0, "along z", unit="m", low=0.5, high=100.0)
    wall: float = tunable(
        0.1, "minimum distance of a vehicle from walls, floor and ceiling", unit="m", low=0.0
    )
    inset: float = tunable(0.3, "minimum distance of places from them", unit="m", low=0.0)
    time: float = tunable(8.0, "duration of a swap", unit="s", low=0.1, high=100.0)

    def __post_init__(self) -> None:
        """Check the bounds."""
        check_bounds(self)

    @property
    def size(self) -> Array:
        """Return length, width and height [m], (3,)."""
        return np.array([self.length, self.width, self.height])

    @property
    def within(self) -> tuple[float, ...]:
        """Return the box that vehicles stay within, for AvoidanceParams."""
        low = (self.wall,) * 3
        return *low, *(self.size - self.wall).tolist()


class CrowdedError(ValueError):
    """Error when no further place was found."""


def random_swap(
    count: int, zone: Zone, room: RoomSize, generator: np.random.Generator
) -> tuple[VehicleWaypoints, ...]:
    """Return a swap of `count` vehicles; raise CrowdedError if they have no room even at rest."""
    places = np.zeros((0, 3))
    for _ in range(count):
        drawn = generator.uniform(room.inset, room.size - room.inset, (DRAWS, 3))
        apart = zone.signed_distance(drawn[:, None] - places)  # (DRAWS, placed)
        clear = np.flatnonzero((apart > CLEAR).all(axis=1))
        if not clear.size:
            raise CrowdedError(f"{len(places)} vehicles at rest leave no room for another ({DRAWS} draws)")
        places = np.vstack([places, drawn[clear[0]]])
    ends = enumerate(zip(places, np.roll(places, 1, axis=0), strict=True), start=1)
    return tuple(waypoints_through(f"cf{k}", (0.0, room.time), both) for k, both in ends)


def plan_swap(
    swarm: tuple[VehicleWaypoints, ...], zone: Zone, room: RoomSize, thrust: tuple[Vehicle, float]
) -> SwarmPlan | None:
    """Return the certified plan of a swap within the walls, None if there is none.

    Args:
        swarm: start and goal of each vehicle.
        zone: kept out of by every pair.
        room: its walls.
        thrust: the vehicle, and the acceleration that it keeps in reserve [m/s^2].
    """
    try:
        plan = avoid_zones(
            swarm, zone, params=AvoidanceParams(steps=STEPS, initial_guesses=1, within=room.within)
        ).plan
        check_feasible(plan, swarm, *thrust)
    except (InfeasibleError, NotFlyableError):
        return None
    return plan
