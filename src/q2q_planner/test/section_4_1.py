"""Way-points of the paper's section 4.1 [s, m]: the first climbs higher than the second, and over it."""

from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, Waypoint

SECTION_4_1 = (
    VehicleWaypoints("cf1", (Waypoint(0, (-1, 0, 0)), Waypoint(20, (0, 0, 2.5)), Waypoint(50, (1, 0, 0)))),
    VehicleWaypoints("cf2", (Waypoint(0, (0, -1, 0)), Waypoint(30, (0, 0, 2.0)), Waypoint(50, (0, 1, 0)))),
)
WRITTEN = """
vehicles:
  cf1: [{t: 0, pos: [-1, 0, 0]}, {t: 20, pos: [0, 0, 2.5]}, {t: 50, pos: [1, 0, 0]}]
  cf2: [{t: 0, pos: [0, -1, 0]}, {t: 30, pos: [0, 0, 2.0]}, {t: 50, pos: [0, 1, 0]}]
"""
"""Content of a waypoint file of them."""
