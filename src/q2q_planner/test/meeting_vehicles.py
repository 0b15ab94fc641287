"""Vehicles whose ways meet: on a circle, all with all, and two head on."""

import numpy as np

from q2q_model.geometry.zone import Cylinder
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, Waypoint

PAPER = Cylinder(0.1, 1.1)


def circle(n: int, duration: float = 10.0) -> list[VehicleWaypoints]:
    """Return n vehicles on a circle of 2 m that all swap with their opposite: every pair meets head on."""
    angle = 2.0 * np.pi * np.arange(n) / n
    start = np.stack([2.0 * np.cos(angle), 2.0 * np.sin(angle), np.ones(n)], -1)
    return [
        VehicleWaypoints(f"cf{i}", (Waypoint(0, tuple(a)), Waypoint(duration, (-a[0], -a[1], 1.0))))
        for i, a in enumerate(start)
    ]


def head_on(duration: float) -> list[VehicleWaypoints]:
    """Return two vehicles that pass each other 2 cm apart."""
    return [
        VehicleWaypoints(name, (Waypoint(0, (-x, y, 1.0)), Waypoint(duration, (x, y, 1.0))))
        for name, x, y in (("cf1", 1.0, 0.0), ("cf2", -1.0, 0.02))
    ]
