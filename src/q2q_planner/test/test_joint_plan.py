"""Joint plans keep every pair out of the zone by proof, at little cost, or say who stands in the way."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import sparse
from scipy.optimize import nnls
from section_4_1 import SECTION_4_1

from q2q_model.geometry.zone import Cylinder, Ellipsoid
from q2q_model.signals.values import Array
from q2q_model.trajectory.polynomials import derive
from q2q_planner.offline.avoidance.avoidance_params import AvoidanceParams
from q2q_planner.offline.avoidance.deviation_space import deform, deviation_space
from q2q_planner.offline.avoidance.joint_plan import avoid_zones
from q2q_planner.offline.avoidance.least_deformation import least_deviations, nonnegative_qp
from q2q_planner.offline.avoidance.near_samples import LOOK
from q2q_planner.offline.avoidance.separating_planes import Planes, watch_pairs
from q2q_planner.offline.avoidance.swarm_samples import sample_swarm
from q2q_planner.offline.avoidance.waypoint_checks import InfeasibleError
from q2q_planner.offline.certificate import certificate
from q2q_planner.offline.certificate.certificate import certify
from q2q_planner.offline.certificate.convex_zone import zone_around
from q2q_planner.offline.minimum_snap.minimum_snap import (
    minimum_snap,
    minimum_snap_plan,
    plan_cost,
    snap_cost,
)
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, Waypoint

PAPER = Cylinder(0.1, 1.1)
DUALITY_GAP = 1e-8
"""Suboptimality at which PIQP stops (its default)."""


def circle(n: int, duration: float = 10.0) -> list[VehicleWaypoints]:
    """Return n vehicles on a circle of 2 m that all swap with their opposite: every pair meets head on."""
    angle = 2.0 * np.pi * np.arange(n) / n
    start = np.stack([2.0 * np.cos(angle), 2.0 * np.sin(angle), np.ones(n)], -1)
    return [
        VehicleWaypoints(f"cf{i}", (Waypoint(0, tuple(a)), Waypoint(duration, (-a[0], -a[1], 1.0))))
        for i, a in enumerate(start)
    ]


def test_section_4_1_avoids_the_zone_at_no_more_than_1_04_times_the_infimum() -> None:
    found = avoid_zones(SECTION_4_1, PAPER)
    assert found.plan.certified
    assert found.certificate.clearance > 0.0
    assert found.infimum == pytest.approx(1.02115e-3, rel=2e-6)
    assert found.infimum < found.cost <= 1.04 * found.infimum
    assert found.cost == pytest.approx(plan_cost(found.plan), rel=1e-12)


def head_on(duration: float) -> list[VehicleWaypoints]:
    """Return two vehicles that pass each other 2 cm apart."""
    return [
        VehicleWaypoints(name, (Waypoint(0, (-x, y, 1.0)), Waypoint(duration, (x, y, 1.0))))
        for name, x, y in (("cf1", 1.0, 0.0), ("cf2", -1.0, 0.02))
    ]


def test_a_slow_flight_takes_the_way_of_a_fast_one() -> None:
    """A curve r(t / T) costs in proportion to T^-7 and has the same way."""
    quick, slow = (avoid_zones(head_on(duration), PAPER) for duration in (5.0, 20_000.0))
    assert slow.cost / slow.infimum == pytest.approx(quick.cost / quick.infimum, rel=1e-6)
    way = [
        found.plan.trajectories[0].at(np.linspace(0.0, t, 99)) for found, t in ((quick, 5), (slow, 20_000))
    ]
    assert way[1] == pytest.approx(way[0], abs=1e-5)


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


def test_waypoints_inside_each_others_zone_are_named() -> None:
    meeting = [
        VehicleWaypoints("cf1", (Waypoint(0, (-1, 0, 1)), Waypoint(5, (0, 0, 1)), Waypoint(9, (1, 0, 1)))),
        VehicleWaypoints(
            "cf2", (Waypoint(0, (0, -1, 1)), Waypoint(5, (0.05, 0, 1.5)), Waypoint(9, (0, 1, 1)))
        ),
    ]
    with pytest.raises(InfeasibleError, match=r"cf1, waypoint 1 and cf2, waypoint 1 lie 0.05 m inside"):
        avoid_zones(meeting, PAPER)


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


def test_a_zone_too_small_for_the_ways_is_named() -> None:
    with pytest.raises(ValueError, match=r"too long for the radius of the zone: \d+ samples, allowed are"):
        avoid_zones(circle(2), Cylinder(1e-5, 1.1))


@settings(deadline=None, max_examples=15)
@given(st.integers(0, 10**6))
def test_cost_is_length_in_the_space_of_deviations(seed: int) -> None:
    for reading in ("stop_and_go", "free"):
        space = deviation_space(SECTION_4_1[0], reading, 4)
        y = np.random.default_rng(seed).normal(size=(space.dimension, 3)) * 0.01
        base = minimum_snap(SECTION_4_1[0], reading)
        curve = deform(base, space, y)
        assert snap_cost(curve) - snap_cost(base) == pytest.approx(float((y**2).sum()), rel=1e-6)
        t = np.linspace(0.0, 50.0, 23)
        assert curve.at(t)[:, :3] - base.at(t)[:, :3] == pytest.approx(space.rows(t) @ y, abs=1e-9)


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 10**6), st.integers(1, 30))
def test_the_dual_is_that_of_nonnegative_least_squares_dense_and_sparse(seed: int, size: int) -> None:
    generator = np.random.default_rng(seed)
    root = generator.normal(size=(size, size + 3))
    gram, asked = root @ root.T + 0.1 * np.eye(size), generator.normal(size=size)
    lower = np.linalg.cholesky(gram)
    exact = nnls(lower.T, np.linalg.solve(lower, asked))[0]

    def cost(x: Array) -> float:
        return float(x @ gram @ x / 2.0 - asked @ x)

    for matrix in (gram, sparse.csr_array(gram)):
        found = nonnegative_qp(matrix, asked)
        assert (found >= 0.0).all()
        assert cost(found) - cost(exact) <= DUALITY_GAP * (1.0 + abs(cost(exact)))


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 10**6), st.integers(1, 100))
def test_every_pair_near_the_zone_is_watched_and_no_other(seed: int, samples: int) -> None:
    """A pair near the zone for one sample is found among boxes of many; those watched before are kept."""
    generator = np.random.default_rng(seed)
    positions = np.cumsum(generator.normal(scale=0.05, size=(samples, 7, 3)), axis=0)
    positions += generator.uniform(-1.0, 1.0, (7, 3))
    pairs, hull = np.triu_indices(7, 1), zone_around(PAPER)
    before = generator.uniform(size=(21, samples)) < 0.02
    watch = watch_pairs(positions, pairs, hull, before)
    rel = positions[:, pairs[0]] - positions[:, pairs[1]]  # (S, 21, 3)
    wide, tall = PAPER.eps * (1.0 + LOOK), PAPER.d + LOOK * PAPER.eps
    near = ((np.hypot(rel[..., 0], rel[..., 1]) < wide) & (np.abs(rel[..., 2]) < tall)).T
    seen = np.zeros_like(before)
    seen[watch.pair, watch.sample] = True
    assert (seen <= near | before).all()
    assert (seen >= before).all()
    moved = np.sqrt((np.diff(rel, axis=0) ** 2).sum(-1)).min(initial=np.inf, axis=0)
    quick = moved > 0.25 * PAPER.eps  # all samples of these pairs are far enough apart for a plane each
    assert (seen == near | before)[quick].all()
    assert watch.rel == pytest.approx(rel[watch.sample, watch.pair])


def test_a_plane_that_is_not_touched_has_no_dual() -> None:
    """Of two planes across the way of a pair, the one 1 cm nearer holds it off and the other is loose."""
    spaces = [deviation_space(vehicle, "stop_and_go", 5) for vehicle in SECTION_4_1]
    samples = sample_swarm(minimum_snap_plan(SECTION_4_1), spaces, np.linspace(1.0, 49.0, 49))
    i, j, x = np.array([0, 0]), np.array([1, 1]), np.tile([1.0, 0.0, 0.0], (2, 1))
    rel_x = samples.base[10, 0, 0] - samples.base[10, 1, 0]
    planes = Planes(i, j, np.array([10, 10]), x, rel_x + np.array([0.05, 0.04]))
    deviations, dual = least_deviations(samples, planes, np.zeros(2))
    assert dual[0] > 0.0
    assert dual[1] == 0.0
    moved = samples.positions(deviations)[10, :, 0]
    assert moved[0] - moved[1] == pytest.approx(rel_x + 0.05, abs=1e-5)  # as soft as HARD


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
