"""Where no joint plan is found, who stands in the way is named."""

import pytest
from meeting_vehicles import PAPER, circle
from section_4_1 import SECTION_4_1

from q2q_model.geometry.zone import Cylinder
from q2q_planner.offline.avoidance.avoidance_params import AvoidanceParams
from q2q_planner.offline.avoidance.joint_plan import avoid_zones
from q2q_planner.offline.avoidance.waypoint_checks import InfeasibleError
from q2q_planner.offline.certificate import certificate
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, Waypoint


def test_waypoints_inside_each_others_zone_are_named() -> None:
    meeting = [
        VehicleWaypoints("cf1", (Waypoint(0, (-1, 0, 1)), Waypoint(5, (0, 0, 1)), Waypoint(9, (1, 0, 1)))),
        VehicleWaypoints(
            "cf2", (Waypoint(0, (0, -1, 1)), Waypoint(5, (0.05, 0, 1.5)), Waypoint(9, (0, 1, 1)))
        ),
    ]
    with pytest.raises(InfeasibleError, match=r"cf1, waypoint 1 and cf2, waypoint 1 lie 0.05 m inside"):
        avoid_zones(meeting, PAPER)


def crossing_of(apart: float) -> list[VehicleWaypoints]:
    """Return two vehicles that pass the same point, the second one `apart` [s] later."""
    return [
        VehicleWaypoints("cf1", (Waypoint(0, (-1, 0, 1)), Waypoint(5, (0, 0, 1)), Waypoint(10, (1, 0, 1)))),
        VehicleWaypoints(
            "cf2", (Waypoint(0, (0, -1, 1)), Waypoint(5 + apart, (0, 0, 1)), Waypoint(10, (0, 1, 1)))
        ),
    ]


@pytest.mark.filterwarnings("error")
def test_waypoints_that_only_a_vehicle_of_10_m_s_keeps_apart_are_named() -> None:
    both = "cf1, waypoint 1 and cf2, waypoint 1 lie 0.1 m inside each other's zone at t = 5 s and 5.00"
    for apart in (0.002, 0.009):
        with pytest.raises(InfeasibleError, match=both):
            avoid_zones(crossing_of(apart), PAPER, "free")


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("apart", [0.01001, 0.02])
def test_a_search_that_diverges_ends_and_names_the_pair(apart: float) -> None:
    with pytest.raises(InfeasibleError, match=r"cf\d and cf\d cannot be kept apart: 0\.\d+ m inside"):
        avoid_zones(crossing_of(apart), PAPER)


def test_a_vehicle_that_parks_on_the_others_waypoint_is_named() -> None:
    parked = [
        VehicleWaypoints("cf1", (Waypoint(0, (-1, 0, 1)), Waypoint(2, (0, 0, 1)))),
        VehicleWaypoints("cf2", (Waypoint(0, (0, -1, 1)), Waypoint(5, (0, 0, 1.5)), Waypoint(9, (0, 1, 1)))),
    ]
    with pytest.raises(InfeasibleError, match=r"cf2, waypoint 1 and cf1, waypoint 1 lie 0.1 m inside"):
        avoid_zones(parked, PAPER)


def test_an_impossible_flight_says_which_pair_and_when() -> None:
    """Two vehicles hold still at their waypoints for 0.2 s so near in time that none can leave the zone."""
    tight = [
        VehicleWaypoints("cf1", (Waypoint(0, (-1, 0, 1)), Waypoint(5, (0, 0, 1)), Waypoint(5.2, (0, 0, 1)))),
        VehicleWaypoints(
            "cf2", (Waypoint(0, (1, 0, 1)), Waypoint(4.9, (0.5, 0, 1)), Waypoint(5.1, (0, 0, 1)))
        ),
    ]
    with pytest.raises(InfeasibleError, match=r"cf\d.* and cf\d.* inside each other's zone at t = [45]"):
        avoid_zones(tight, PAPER)


def test_a_plan_of_which_nothing_is_computed_is_not_said_to_be_inside(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(certificate, "MOST_STRETCHES", 0)
    with pytest.raises(
        InfeasibleError, match=r"no pair is proven .* in any of 1 initial guesses: .* more than 0$"
    ):
        avoid_zones(SECTION_4_1, PAPER, params=AvoidanceParams(initial_guesses=1, steps=2))


def test_a_zone_too_small_for_the_ways_is_named() -> None:
    with pytest.raises(ValueError, match=r"too long for the radius of the zone: \d+ samples, maximum"):
        avoid_zones(circle(2), Cylinder(1e-5, 1.1))
