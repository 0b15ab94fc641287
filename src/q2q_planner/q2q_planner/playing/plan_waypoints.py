"""Read waypoints off a plan: where the pieces of its trajectories meet."""

import numpy as np

from q2q_model.trajectory.polynomials import SwarmPlan, Trajectory
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, Waypoint


def waypoints_of(plan: SwarmPlan) -> tuple[VehicleWaypoints, ...]:
    """Return the first point of every piece and the last point of all, one row a vehicle.

    Raises:
        ValueError: pieces too short, or points too far away, for waypoints.
    """
    return tuple(map(_vehicle, plan.names, plan.trajectories))


def _vehicle(name: str, trajectory: Trajectory) -> VehicleWaypoints:
    times = np.concatenate([[0.0], np.cumsum(trajectory.durations)])
    rows = zip(times.tolist(), trajectory.at(times).tolist(), strict=True)
    return VehicleWaypoints(name, tuple(Waypoint(t, (x, y, z), yaw) for t, (x, y, z, yaw) in rows))
