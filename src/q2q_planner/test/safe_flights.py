"""Flights that the safe law leads, and what is measured of vehicles that follow exactly."""

import numpy as np
from resting_signals import resting_state

from q2q_model.geometry.zone import Cylinder
from q2q_model.signals.values import SetpointStatus, SwarmSetpoint, SwarmState
from q2q_model.trajectory.polynomials import SwarmPlan
from q2q_planner.offline.minimum_snap.minimum_snap import minimum_snap_plan
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, Waypoint
from q2q_planner.online.safe.motion.safe_replanner_params import SafeReplannerParams

TICK = 0.01
PARAMS = SafeReplannerParams(eps=0.2, tracking=0.02)
ZONE = Cylinder(PARAMS.eps, PARAMS.d)
BROKEN = SetpointStatus.PROMISE_BROKEN


def swap(height: float = 1.0) -> SwarmPlan:
    """Return two vehicles that swap places exactly head on."""
    return minimum_snap_plan(
        [
            VehicleWaypoints("cf1", (Waypoint(0, (-1.5, 0, height)), Waypoint(6, (1.5, 0, height)))),
            VehicleWaypoints("cf2", (Waypoint(0, (1.5, 0, height)), Waypoint(6, (-1.5, 0, height)))),
        ]
    )


def hover(seconds: float) -> SwarmPlan:
    """Return one vehicle that hovers."""
    return minimum_snap_plan(
        [VehicleWaypoints("cf1", (Waypoint(0, (0, 0, 1)), Waypoint(seconds, (0, 0, 1))))]
    )


def seen(setpoint: SwarmSetpoint, age: float = 0.0) -> SwarmState:
    """Return the state of vehicles that follow exactly, measured `age` ago."""
    n = len(setpoint.names)
    return resting_state(setpoint.t, setpoint.names, setpoint.pos, vel=setpoint.vel, age=np.full(n, age))
