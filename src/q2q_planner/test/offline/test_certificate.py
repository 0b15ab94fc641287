"""What a certificate proves is true at every time, and is not far below the truth."""

from itertools import combinations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.polynomial import Polynomial

from q2q_model.geometry.zone import Cylinder, Ellipsoid, Zone
from q2q_model.signals.values import Array
from q2q_model.trajectory.bernstein import control_points, split_in_half
from q2q_model.trajectory.polynomials import SwarmPlan, Trajectory
from q2q_planner.offline.certificate import certificate
from q2q_planner.offline.certificate.branch_and_bound import TOLERANCE
from q2q_planner.offline.certificate.certificate import certify
from q2q_planner.offline.certificate.convex_zone import ConvexZone, zone_around
from q2q_planner.offline.certificate.rounding_bound import rounding_slack
from q2q_planner.offline.certificate.shared_pieces import shared_pieces, split_at
from q2q_planner.offline.minimum_snap.minimum_snap import minimum_snap_plan
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, Waypoint

NAMES = ("cf1", "cf2", "cf3")
ZONES = (Cylinder(0.1, 1.1), Cylinder(0.3, 0.2), Ellipsoid(0.4, 0.7))


def random_plan(seed: int, vehicles: int = 3) -> SwarmPlan:
    generator = np.random.default_rng(seed)
    swarm = []
    for row in range(vehicles):
        times = np.concatenate([[0.0], np.cumsum(generator.uniform(0.5, 4.0, 3))])
        points = (Waypoint(float(t), tuple(generator.normal(size=3))) for t in times)
        swarm.append(VehicleWaypoints(f"cf{row}", tuple(points)))
    return minimum_snap_plan(swarm, "free")


def sampled_clearance(plan: SwarmPlan, zone: Zone) -> float:
    t = np.linspace(0.0, plan.duration, 5_001)
    pos = [trajectory.at(t)[:, :3] for trajectory in plan.trajectories]
    return min(float(zone.signed_distance(a - b).min()) for a, b in combinations(pos, 2))


@settings(deadline=None, max_examples=15)
@given(st.integers(0, 10**6), st.sampled_from(ZONES))
def test_the_clearance_is_below_every_sample_and_near_the_least(seed: int, zone: Zone) -> None:
    plan, hull = random_plan(seed), zone_around(zone)
    proven, seen = certify(plan, zone).clearance, sampled_clearance(plan, hull)
    assert proven <= seen
    # 5 001 samples of up to 12 s, at up to some 10 m/s: 12 mm between a sample and the true least
    assert proven >= seen - TOLERANCE - 2.4e-2


@pytest.mark.parametrize("zone", ZONES)
def test_a_search_that_ends_at_the_first_contact_judges_as_the_whole_one_does(zone: Zone) -> None:
    proofs = [(certify(plan, zone), certify(plan, zone, enough=0.0)) for plan in map(random_plan, range(12))]
    assert {whole.holds for whole, _ in proofs} == {True, False}
    assert all(short == whole if whole.holds else short.clearance == -np.inf for whole, short in proofs)


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 10**6), st.sampled_from(((0.6, -0.8, 0.0), (0.0, 0.0, -1.0))))
def test_the_clearance_along_a_line_is_that_of_the_extrema(seed: int, unit: tuple[float, ...]) -> None:
    """Of a polynomial of degree 7 it is the least at ends and roots of the derivative, to 10 um."""
    generator = np.random.default_rng(seed)
    along, length = generator.normal(scale=0.1, size=8), generator.uniform(0.5, 2.0)
    along[0] += 4.0
    place = generator.normal(scale=0.1, size=(1, 4, 8))
    moved = place.copy()
    moved[0, :3] += np.multiply.outer(unit, along)
    curves = tuple(Trajectory(np.array([length]), one) for one in (place, moved))
    p = Polynomial(along)
    roots = p.deriv().roots()
    real = roots.real[(abs(roots.imag) < 1e-9) & (roots.real > 0.0) & (roots.real < length)]
    least = p(np.array([0.0, length, *real])).min() - (1.1 if unit[2] else 0.1)
    assume(least > 0.0)
    proof = certify(SwarmPlan(("cf1", "cf2"), curves), Cylinder(0.1, 1.1))
    assert least - 2.0 * TOLERANCE <= proof.clearance <= least


@pytest.mark.parametrize("far", [0.0, 1e5])
def test_a_clearance_is_less_than_the_distance_by_what_rounding_may_be(far: float) -> None:
    """Of vehicles at rest the bound is their distance; far from the origin positions are coarser."""
    place = np.zeros((1, 4, 1))
    place[0, :3, 0] = far, -1.0, 0.5
    other = place.copy()
    other[0, :2, 0] += 3.0, -4.0
    curves = tuple(Trajectory(np.array([2.0]), one) for one in (place, other))
    slack = rounding_slack(curves)
    assert slack > (1e-9 if far else 0.0)
    proof = certify(SwarmPlan(("cf1", "cf2"), curves), Cylinder(0.1, 1.1))
    assert proof.clearance == pytest.approx(4.9 - slack, abs=1e-13)


def test_a_pass_between_samples_is_not_missed() -> None:
    """At 100 m/s two vehicles are inside for 2 ms: any usual sampling sees nothing."""
    there = Trajectory(np.array([10.0]), np.array([[[-500.0, 100.0], [0.0, 0.0], [0.0, 0.0], [0.0, 0.0]]]))
    still = Trajectory(np.array([10.0]), np.zeros((1, 4, 2)))
    proof = certify(SwarmPlan(("cf1", "cf2"), (there, still)), Cylinder(0.1, 1.1))
    assert not proof.holds
    assert proof.clearance == pytest.approx(-0.1, abs=2 * TOLERANCE)
    assert proof.t == pytest.approx(5.0, abs=1e-3)
    assert proof.pair == ("cf1", "cf2")


def test_a_vehicle_at_rest_after_its_end_is_still_there() -> None:
    short = VehicleWaypoints("cf1", (Waypoint(0, (0, 0, 1)), Waypoint(1, (0.5, 0, 1))))
    late = VehicleWaypoints("cf2", (Waypoint(0, (0.5, 3, 1)), Waypoint(20, (0.5, -3, 1))))
    proof = certify(minimum_snap_plan((short, late)), Cylinder(0.1, 1.1))
    assert proof.clearance == pytest.approx(-0.1, abs=2 * TOLERANCE)
    assert proof.t == pytest.approx(10.0, abs=1e-2)


def _straight(start: Array, end: Array) -> Trajectory:
    """Return a line flown in 1 s, with the eight coefficients of a planned piece."""
    coefficients = np.zeros((1, 4, 8))
    coefficients[0, :2, 0], coefficients[0, :2, 1] = start, end - start
    return Trajectory(np.ones(1), coefficients)


def test_a_pair_at_rest_is_found_beside_one_whose_box_is_nearer() -> None:
    """Box and midpoint of a pair at rest are one distance; computed twice, it differs in its last bit.

    The third vehicle passes on a diagonal: its box holds the pair at rest, from which it stays 2 m away.
    """
    passing = _straight(np.array([-4.0, 0.0]), np.array([0.0, -4.0]))
    for here, there in np.random.default_rng(0).uniform(-0.4, 0.4, (200, 2, 2)):
        at_rest = _straight(here, here), _straight(there, there)
        for curves in (at_rest, (*at_rest, passing)):
            proof = certify(SwarmPlan(NAMES[: len(curves)], curves), Cylinder(0.01, 1.1))
            assert proof.pair == NAMES[:2]
            gap = float(np.hypot(*(here - there))) - 0.01
            assert proof.clearance == pytest.approx(gap, abs=TOLERANCE)


def test_a_graze_of_a_tenth_of_a_millimetre_is_told_from_a_touch() -> None:
    for gap, holds in ((1e-4, True), (-1e-4, False)):
        there = VehicleWaypoints("cf1", (Waypoint(0, (-2, 0.1 + gap, 1)), Waypoint(9, (2, 0.1 + gap, 1))))
        back = VehicleWaypoints("cf2", (Waypoint(0, (2, 0, 1)), Waypoint(9, (-2, 0, 1))))
        assert certify(minimum_snap_plan((there, back)), Cylinder(0.1, 1.1)).holds is holds


def test_a_plan_with_too_many_stretches_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    plan = random_plan(0, vehicles=4)
    stretches = 6 * len(shared_pieces(plan.trajectories).durations)  # of 6 pairs
    monkeypatch.setattr(certificate, "MOST_STRETCHES", stretches)
    assert not certify(plan, ZONES[0]).not_computed
    monkeypatch.setattr(certificate, "MOST_STRETCHES", stretches - 1)
    proof = certify(plan, ZONES[0])
    assert not proof.holds
    words = f"of 4 vehicles have {stretches} stretches of pairs, more than {stretches - 1}"
    assert words in proof.not_computed


def test_one_vehicle_is_alone() -> None:
    alone = VehicleWaypoints("cf1", (Waypoint(0, (0, 0, 1)), Waypoint(1, (0.5, 0, 1))))
    assert certify(minimum_snap_plan((alone,)), Cylinder()).holds


@given(st.integers(0, 10**6), st.floats(0.0, 1.0))
def test_control_points_hold_their_curve_and_halve_exactly(seed: int, share: float) -> None:
    coefficients = np.random.default_rng(seed).normal(size=(3, 8))
    points = control_points(coefficients, np.array([2.0, 0.5, 1.0]))
    value = (coefficients * (share * np.array([2.0, 0.5, 1.0])[:, None]) ** np.arange(8)).sum(-1)
    assert (points.min(-1) - 1e-9 <= value).all()  # rounding
    assert (value <= points.max(-1) + 1e-9).all()
    left, right = split_in_half(points)
    middle = (coefficients * (0.5 * np.array([2.0, 0.5, 1.0])[:, None]) ** np.arange(8)).sum(-1)
    assert left[:, -1] == pytest.approx(middle, abs=1e-9)
    assert right[:, 0] == pytest.approx(middle, abs=1e-9)
    assert np.array_equal(left[:, 0], points[:, 0])
    assert np.array_equal(right[:, -1], points[:, -1])


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 10**6))
def test_cutting_a_trajectory_changes_no_value(seed: int) -> None:
    plan = random_plan(seed)
    cuts = np.sort(np.random.default_rng(seed).uniform(0.0, plan.duration + 2.0, 7))
    t = np.linspace(0.0, plan.duration + 1.0, 97)
    for trajectory in plan.trajectories:
        # shifting powers of a degree-7 polynomial with coefficients up to 1e3 costs some digits
        assert split_at(trajectory, cuts).at(t) == pytest.approx(trajectory.at(t), abs=1e-7)
    shared = shared_pieces(plan.trajectories)
    assert shared.coefficients.shape[:3] == (len(shared.starts), 3, 3)


@given(
    st.sampled_from(ZONES),
    st.tuples(*[st.floats(-2.0, 2.0)] * 3),
    st.tuples(*[st.floats(-1.0, 1.0)] * 3).filter(lambda n: np.linalg.norm(n) > 0.1),
)
def test_no_plane_promises_more_than_the_true_distance(zone: Zone, rel_pos: tuple, normal: tuple) -> None:
    hull, unit = zone_around(zone), np.array(normal) / np.linalg.norm(normal)
    rel = np.array(rel_pos)
    assume(hull.signed_distance(rel) > 0.0)
    assert rel @ unit - hull.support(unit) <= zone.signed_distance(rel) + 1e-9
    best, distance = hull.nearest(rel)
    assert rel @ best - hull.support(best) == pytest.approx(distance, abs=1e-9)


@given(st.tuples(*[st.floats(-2.0, 2.0)] * 3))
def test_a_convex_zone_around_a_cylinder_is_the_cylinder(rel_pos: tuple) -> None:
    rel, cylinder = np.array(rel_pos), Cylinder(0.3, 0.9)
    assert zone_around(cylinder).signed_distance(rel) == pytest.approx(
        cylinder.signed_distance(rel), abs=1e-12
    )


def test_a_convex_zone_around_any_shape_holds_it_closely() -> None:
    class Pear:
        """A zone that is not convex: radius 0.2 + 0.1 cos(4 z) up to 0.8 m."""

        def signed_distance(self, rel_pos: np.ndarray) -> np.ndarray:
            across, height = np.hypot(rel_pos[..., 0], rel_pos[..., 1]), np.abs(rel_pos[..., 2])
            return np.maximum(across - 0.2 - 0.1 * np.cos(4.0 * height), height - 0.8)

    hull = zone_around(Pear())
    heights = np.linspace(-0.8, 0.8, 401)
    rim = np.stack([0.2 + 0.1 * np.cos(4.0 * heights), np.zeros(401), heights], -1)
    assert (hull.signed_distance(rim) <= 1e-9).all()
    assert hull.eps == pytest.approx(0.3, abs=2e-3)
    assert hull.d == pytest.approx(0.8, abs=1.1e-2)  # one slice


def test_an_empty_or_endless_zone_is_refused() -> None:
    class Level:
        def __init__(self, value: float) -> None:
            self.value = value

        def signed_distance(self, rel_pos: np.ndarray) -> np.ndarray:
            return np.full(rel_pos.shape[:-1], self.value)

    with pytest.raises(ValueError, match="the zone is empty"):
        zone_around(Level(1.0))
    with pytest.raises(ValueError, match="reaches beyond"):
        zone_around(Level(-1.0))
    assert isinstance(zone_around(Cylinder()), ConvexZone)
