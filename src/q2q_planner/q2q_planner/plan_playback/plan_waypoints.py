"""Waypoints of a plan: the ends of its pieces."""

import numpy as np

from q2q_model.trajectory.polynomials import SwarmPlan, Trajectory
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, waypoints_through


def waypoints_of(plan: SwarmPlan) -> tuple[VehicleWaypoints, ...]:
    """Return each vehicle's waypoints: the start of every piece and the end of the last.

    Raises:
        ValueError: pieces are too short, or points too far away, for waypoints.
    """
    return tuple(map(_vehicle, plan.names, plan.trajectories))


def _vehicle(name: str, trajectory: Trajectory) -> VehicleWaypoints:
    times = np.concatenate([[0.0], np.cumsum(trajectory.durations)])
    return waypoints_through(name, times, trajectory.at(times))
