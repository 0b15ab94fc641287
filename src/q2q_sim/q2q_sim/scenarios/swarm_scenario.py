"""Scenario `swarmN`: two counter-rotating rings of vehicles, one above the other.

Odd vehicles fly in the lower ring counter-clockwise, even ones half a metre above clockwise, so that every
vehicle passes under many others. Neighbours in a ring are SPACING apart; the radius follows from their
number, and all fly at SPEED.

    angle_k(t) = 2 pi k / n + direction * SPEED t / radius
"""

import math

from q2q_model.vehicle.constants import CRAZYFLIE_2_0
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, Waypoint
from q2q_sim.scenarios.room_profiles import IDEAL
from q2q_sim.scenarios.scenario import Scenario

SPACING = 0.6
"""Along the ring [m]: six times eps, well outside each other's downwash."""
SPEED = 0.5
"""[m/s]: the slower flyover of Table 2."""
HEIGHTS = (1.0, 1.5)
"""Heights of the rings [m]: the smaller distance of Table 2 apart."""
DURATION = 30.0
"""[s]"""
POINT_EVERY = 1.0
"""Time between waypoints [s]."""


def swarm_scenario(count: int) -> Scenario:
    """Return the scenario of `count` vehicles, 1 or more (scenario_files.swarm_size)."""
    return Scenario(
        name=f"swarm{count}",
        description=f"{count} Crazyflies on two counter-rotating rings, passing under each other",
        duration=DURATION,
        vehicle=CRAZYFLIE_2_0,
        waypoints=tuple(_ring_path(index, count) for index in range(count)),
        reading="free",
        wake="paper",
        model="paper_law",
        vicon=IDEAL.vicon,
        radio=IDEAL.radio,
        overrides=IDEAL.overrides,
    )


def _ring_path(index: int, count: int) -> VehicleWaypoints:
    upper = index % 2
    in_ring = (count + 1 - upper) // 2
    widest = (count + 1) // 2
    radius = max(widest * SPACING / (2.0 * math.pi), SPACING)
    start = 2.0 * math.pi * (index // 2) / in_ring
    turn = (-1.0 if upper else 1.0) * SPEED / radius
    points = []
    for step in range(round(DURATION / POINT_EVERY) + 1):
        t = step * POINT_EVERY
        angle = start + turn * t
        points.append(Waypoint(t, (radius * math.cos(angle), radius * math.sin(angle), HEIGHTS[upper])))
    return VehicleWaypoints(f"cf{index + 1}", tuple(points))
