"""Waypoints that no trajectory can meet are refused in words that name vehicle, waypoint and bound."""

import pytest

from q2q_planner.offline.minimum_snap.flight_limits import FlightLimits
from q2q_planner.offline.minimum_snap.waypoint_document import swarm_from_document
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, Waypoint, check_swarm

LIMITS = FlightLimits()
HERE = (0.0, 0.0, 1.0)


def test_a_waypoint_with_nan_names_vehicle_waypoint_and_coordinate() -> None:
    with pytest.raises(ValueError, match=r"cf1, waypoint 1: y = nan; must be a finite number"):
        VehicleWaypoints("cf1", (Waypoint(0.0, HERE), Waypoint(1.0, (0.0, float("nan"), 1.0))))


@pytest.mark.parametrize(
    ("t", "message"), [(5.0, "coincides"), (4.0, "before the previous"), (5.0 + 1e-6, "at least 0.001 s")]
)
def test_times_that_do_not_rise_are_refused(t: float, message: str) -> None:
    with pytest.raises(ValueError, match=rf"cf1, waypoint 2: .*{message}"):
        VehicleWaypoints("cf1", (Waypoint(0.0, HERE), Waypoint(5.0, HERE), Waypoint(t, HERE)))


def test_one_waypoint_is_no_flight() -> None:
    with pytest.raises(ValueError, match=r"cf1: 1 waypoint\(s\) given; must be at least 2"):
        VehicleWaypoints("cf1", (Waypoint(0.0, HERE),))


def test_a_swarm_needs_unique_names_and_a_common_start() -> None:
    first = VehicleWaypoints("cf1", (Waypoint(0.0, HERE), Waypoint(1.0, HERE)))
    late = VehicleWaypoints("cf2", (Waypoint(0.5, HERE), Waypoint(1.0, HERE)))
    with pytest.raises(ValueError, match="cf1: name given 2 times"):
        check_swarm((first, first))
    with pytest.raises(ValueError, match=r"cf2, waypoint 0: t = 0.5 s"):
        check_swarm((first, late))
    with pytest.raises(ValueError, match="at least 1"):
        check_swarm(())


def test_a_document_becomes_the_waypoints_it_says() -> None:
    document = {"vehicles": {"cf1": [{"t": 0, "pos": [1, 2, 3]}, {"t": 2.5, "pos": [0, 0, 1], "yaw": 0.5}]}}
    (vehicle,) = swarm_from_document(document, LIMITS)
    assert vehicle == VehicleWaypoints(
        "cf1", (Waypoint(0.0, (1.0, 2.0, 3.0)), Waypoint(2.5, (0.0, 0.0, 1.0), 0.5))
    )


@pytest.mark.parametrize(
    ("document", "message"),
    [
        (None, "the file: got None, expected a mapping with vehicles"),
        ({"vehicles": {"cf1": 3}}, "the file: vehicles.cf1 = 3; must be a list of waypoints"),
        ({"vehicles": {"cf1": [{"t": 0}]}}, "cf1, waypoint 0: pos is missing"),
        (
            {"vehicles": {"cf1": [{"t": 0, "pos": [1, 2]}]}},
            r"waypoint 0: pos = \[1, 2\]; must be \[x, y, z\] in metres",
        ),
        (
            {"vehicles": {"cf1": [{"t": "x", "pos": [1, 2, 3]}]}},
            "cf1, waypoint 0: t = 'x'; must be a number",
        ),
        (
            {"vehicles": {"cf1": [{"t": 0, "pos": [1, 2, 3], "yw": 0}]}},
            "unknown key 'yw'; did you mean yaw",
        ),
    ],
)
def test_a_malformed_document_is_refused_where_it_is_wrong(document: object, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        swarm_from_document(document, LIMITS)
