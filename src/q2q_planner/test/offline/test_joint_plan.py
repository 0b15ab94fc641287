"""Joint plans keep every pair out of the zone by proof, at little cost."""

import numpy as np
import pytest
from meeting_vehicles import PAPER, circle, head_on
from section_4_1 import SECTION_4_1

from q2q_model.geometry.zone import Cylinder, Ellipsoid
from q2q_model.trajectory.polynomials import derive
from q2q_planner.offline.avoidance.avoidance_params import AvoidanceParams
from q2q_planner.offline.avoidance.joint_plan import avoid_zones
from q2q_planner.offline.certificate.certificate import certify
from q2q_planner.offline.minimum_snap.minimum_snap import (
    minimum_snap_plan,
    plan_cost,
)
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, Waypoint


def test_section_4_1_avoids_the_zone_at_no_more_than_1_04_times_the_infimum() -> None:
    found = avoid_zones(SECTION_4_1, PAPER)
    assert found.plan.certified
    assert found.certificate.clearance > 0.0
    assert found.infimum == pytest.approx(1.02115e-3, rel=2e-6)
    assert found.infimum < found.cost <= 1.04 * found.infimum
    assert found.cost == pytest.approx(plan_cost(found.plan), rel=1e-12)


def test_a_slow_flight_takes_the_way_of_a_fast_one() -> None:
    """A curve r(t / T) costs in proportion to T^-7 and has the same way."""
    quick, slow = (avoid_zones(head_on(duration), PAPER) for duration in (5.0, 20_000.0))
    assert slow.cost / slow.infimum == pytest.approx(quick.cost / quick.infimum, rel=1e-6)
    way = [
        found.plan.trajectories[0].at(np.linspace(0.0, t, 99)) for found, t in ((quick, 5), (slow, 20_000))
    ]
    assert way[1] == pytest.approx(way[0], abs=1e-5)


def test_a_short_exchange_is_planned_alike_before_a_long_hover() -> None:
    """Of 2 h, 3 s lie between two of 512 equally spaced times."""

    def with_hover(end: float) -> list[VehicleWaypoints]:
        return [
            VehicleWaypoints(
                name, (Waypoint(0, (x, 0, 1)), Waypoint(3, (-x, 0, 1)), Waypoint(end, (-x, 0, z)))
            )
            for name, x, z in (("cf1", -1.0, 1.2), ("cf2", 1.0, 1.0))
        ]

    ratio = [found.cost / found.infimum for found in (avoid_zones(with_hover(t), PAPER) for t in (60, 7200))]
    assert ratio[1] == pytest.approx(ratio[0], rel=2e-3)  # samples lie elsewhere


@pytest.mark.parametrize("eps", [0.08, 0.12])
def test_planes_that_nearly_contradict_each_other_bend_no_curve_wildly(eps: float) -> None:
    """Two pass below a third, which must give way and be back: the dual of the planes grows to 1e6."""
    below = [
        Waypoint(0, (0, -1.5, 1)),
        Waypoint(10, (0, -1.5, 1)),
        Waypoint(20, (0, 0, 1)),
        Waypoint(30, (0, 1.5, 1)),
    ]
    through = [
        Waypoint(0, (-1.5, 0, 1.5)),
        Waypoint(18, (0, 0, 1.5)),
        Waypoint(22, (0, 0, 1.5)),
        Waypoint(30, (1.5, 0, 1.5)),
    ]
    above = [Waypoint(0, (0, 0, 2)), Waypoint(40, (0, 0, 2))]
    stack = [VehicleWaypoints(f"cf{k}", tuple(one)) for k, one in enumerate((below, through, above), 1)]
    found = avoid_zones(stack, Cylinder(eps, 1.1))
    assert found.cost < 100.0 * found.infimum


@pytest.mark.parametrize("zone", [PAPER, Ellipsoid.around(PAPER), Cylinder(0.25, 1.1)])
def test_an_avoiding_plan_meets_its_waypoints_at_rest_and_stays_smooth(zone: Cylinder | Ellipsoid) -> None:
    plan = avoid_zones(SECTION_4_1, zone).plan
    t = np.linspace(0.0, 50.0, 20_001)
    pos = [trajectory.at(t)[:, :3] for trajectory in plan.trajectories]
    assert zone.signed_distance(pos[0] - pos[1]).min() > 0.0  # the certificate, seen by samples
    for vehicle, trajectory in zip(SECTION_4_1, plan.trajectories, strict=True):
        for waypoint in vehicle.waypoints:
            at = np.asarray(waypoint.t)
            assert trajectory.at(at)[:3] == pytest.approx(np.array(waypoint.pos), abs=1e-9)
            for p in (1, 2, 3):
                assert trajectory.at(at, p)[:3] == pytest.approx(0.0, abs=1e-9)
        for p in range(4):
            derived = derive(trajectory.coefficients, p)[:, :3]
            ends = (derived * (trajectory.durations[:, None, None] ** np.arange(derived.shape[-1]))).sum(-1)
            assert ends[:-1] == pytest.approx(derived[1:, :, 0], abs=1e-9)  # C3 at every knot


@pytest.mark.parametrize("n", [2, 3, 5, 8])
def test_a_circle_of_vehicles_that_all_swap_is_sorted_out(n: int) -> None:
    found = avoid_zones(circle(n), Cylinder(0.2, 1.1))
    assert certify(found.plan, Cylinder(0.2, 1.1)).holds


def test_the_free_reading_costs_less_and_is_certified_too() -> None:
    through = [
        VehicleWaypoints(
            "cf1", (Waypoint(0, (-2, 0, 1)), Waypoint(4, (0.3, 0.4, 1)), Waypoint(9, (2, 0, 1)))
        ),
        VehicleWaypoints(
            "cf2", (Waypoint(0, (2, 0.1, 1)), Waypoint(5, (-0.4, 0, 1)), Waypoint(9, (-2, 0.1, 1)))
        ),
    ]
    free, stopping = avoid_zones(through, PAPER, "free"), avoid_zones(through, PAPER, "stop_and_go")
    assert free.plan.certified
    assert free.cost < stopping.cost


def test_vehicles_far_apart_get_the_closed_form() -> None:
    far = [
        VehicleWaypoints("cf1", (Waypoint(0, (0, 0, 1)), Waypoint(5, (1, 0, 1)))),
        VehicleWaypoints("cf2", (Waypoint(0, (0, 5, 1)), Waypoint(5, (1, 5, 1)))),
    ]
    found = avoid_zones(far, PAPER)
    assert found.cost == found.infimum
    assert found.steps == 0
    assert found.plan.certified


def test_a_warm_start_ends_where_it_began() -> None:
    cold = avoid_zones(SECTION_4_1, PAPER)
    warm = avoid_zones(SECTION_4_1, PAPER, warm=cold.plan)
    assert warm.steps <= cold.steps
    assert warm.cost == pytest.approx(cold.cost, rel=1e-3)  # STILL, over some steps
    renamed = [VehicleWaypoints(name, one.waypoints) for name, one in zip("ab", SECTION_4_1, strict=True)]
    with pytest.raises(ValueError, match="warm start of cf1, cf2: expected a, b"):
        avoid_zones(renamed, PAPER, warm=cold.plan)


@pytest.mark.parametrize(
    "warm", [*(head_on(t) for t in (1.0, 90.0)), circle(2)], ids=["short", "long", "other"]
)
def test_a_warm_start_may_be_another_flight(warm: list[VehicleWaypoints]) -> None:
    """Samples are those of the flight that is planned, not those of the plan around which it is."""
    named = [VehicleWaypoints(name, one.waypoints) for name, one in zip(("cf1", "cf2"), warm, strict=True)]
    cold = avoid_zones(head_on(20.0), PAPER)
    found = avoid_zones(head_on(20.0), PAPER, warm=minimum_snap_plan(named))
    assert found.cost == pytest.approx(cold.cost, rel=1e-3)  # STILL, over some steps


def test_a_room_in_which_all_change_places_at_once_is_sorted_out() -> None:
    """More planes than are solved densely: the search goes on with those that are touched."""
    count = 60
    generator = np.random.default_rng(count)
    grid = 0.6 * np.stack(np.divmod(np.arange(count), 8), axis=-1)
    places = np.column_stack([grid, np.full(count, 1.2)]) + generator.uniform(-0.1, 0.1, (count, 3))
    ends = zip(places.tolist(), places[generator.permutation(count)].tolist(), strict=True)
    swarm = [
        VehicleWaypoints(f"cf{row}", (Waypoint(0, tuple(a)), Waypoint(10, tuple(b))))
        for row, (a, b) in enumerate(ends)
    ]
    found = avoid_zones(swarm, PAPER, params=AvoidanceParams(initial_guesses=1))
    assert found.certificate.holds
    assert found.infimum < found.cost < 1.2 * found.infimum


def test_the_search_is_the_same_twice() -> None:
    params = AvoidanceParams(initial_guesses=3, seed=4)
    first, second = (avoid_zones(circle(4), Cylinder(0.2, 1.1), params=params) for _ in range(2))
    assert first.cost == second.cost
