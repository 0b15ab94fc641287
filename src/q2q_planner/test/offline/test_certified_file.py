"""A plan file is certified only if that is proven when it is read: no edit of its numbers passes."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from q2q_model.documents.checksummed_json import checksum
from q2q_model.geometry.zone import Cylinder, Ellipsoid, Zone
from q2q_model.trajectory import plan_file
from q2q_model.trajectory.polynomials import SwarmPlan, Trajectory, setpoint_at
from q2q_planner.offline.avoidance.joint_plan import AvoidancePlan, avoid_zones
from q2q_planner.offline.certificate.certificate import as_certified, certify
from q2q_planner.offline.certificate.certified_file import load_plan
from q2q_planner.offline.certificate.convex_zone import zone_around, zone_of_profile
from q2q_planner.offline.certificate.reference_steps import largest_steps
from q2q_planner.offline.minimum_snap.minimum_snap import Reading, minimum_snap
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, Waypoint

ZONE = Cylinder(0.1, 1.1)
Document = dict[str, object]


@pytest.fixture(scope="module")
def made() -> AvoidancePlan:
    """Return a certified plan of two vehicles that cross, whose zone is touched."""
    swarm = (
        VehicleWaypoints("cf1", (Waypoint(0.0, (-1.0, 0.0, 1.0)), Waypoint(4.0, (1.0, 0.0, 1.0)))),
        VehicleWaypoints("cf2", (Waypoint(0.0, (0.0, -1.0, 1.5)), Waypoint(4.0, (0.0, 1.0, 1.5)))),
    )
    return avoid_zones(swarm, ZONE)


def written(plan: SwarmPlan, file: Path, edit: Callable[[Document], object] | None = None) -> Path:
    """Write a plan; a hostile edit of its entries gets the checksum that fits."""
    document = json.loads(plan_file.encode(plan))
    if edit is not None:
        document.pop("checksum")
        edit(document)
        document["checksum"] = checksum(document)
    file.write_text(json.dumps(document))
    return file


def nearer(made: AvoidancePlan, by: float) -> SwarmPlan:
    """Return the plan with the second vehicle moved [m] towards the first, where they are nearest."""
    pos = setpoint_at(made.plan, made.certificate.t).pos
    normal, _ = zone_around(ZONE).nearest(pos[1] - pos[0])
    first, second = made.plan.trajectories
    coefficients = second.coefficients.copy()
    coefficients[:, :3, 0] -= by * normal
    return replace(made.plan, trajectories=(first, Trajectory(second.durations, coefficients)))


def test_a_certified_plan_is_read_as_certified_for_its_zone(made: AvoidancePlan, tmp_path: Path) -> None:
    found = load_plan(written(made.plan, tmp_path / "plan.json"))
    assert found.certified
    assert found.zone_profile == ((ZONE.eps, ZONE.d),)
    assert certify(found, ZONE).clearance == made.certificate.clearance


def test_a_coefficient_that_is_changed_by_hand_is_found(made: AvoidancePlan, tmp_path: Path) -> None:
    file = written(made.plan, tmp_path / "plan.json")
    document = json.loads(file.read_text())
    document["vehicles"][1]["coefficients"][0][2][0] += 1e-6
    file.write_text(json.dumps(document))
    with pytest.raises(ValueError, match=r"plan\.json is not a plan: .* edited after it was certified"):
        load_plan(file)
    document["certified"] = False
    file.write_text(json.dumps(document))
    assert not load_plan(file).certified


def test_vehicles_moved_into_their_zone_do_not_pass_with_a_new_checksum(
    made: AvoidancePlan, tmp_path: Path
) -> None:
    assert load_plan(
        written(nearer(made, -0.001), tmp_path / "apart.json")
    ).certified  # true of these numbers
    file = written(nearer(made, made.certificate.clearance + 0.001), tmp_path / "plan.json")
    assert plan_file.load(file).certified  # its checksum fits
    with pytest.raises(ValueError, match=r"is not: cf1 and cf2 have a proven clearance of -0\.001"):
        load_plan(file)


def test_a_dent_in_the_zone_does_not_pass(made: AvoidancePlan, tmp_path: Path) -> None:
    """Distances to a profile that is not convex would be too large, to one without a face wrong."""
    dents = ([[0.1, 0.5], [0.01, 0.6], [0.1, 1.1]], [[0.1, 1.1], [0.1, 0.2]], [[0.0, 0.0]], [[1e-9, 1e-9]])
    flat = ([[0.0, 0.4]], [[0.4, 0.0]], [[0.0, 0.2], [0.0, 0.4]])
    for number, profile in enumerate((*dents, *flat)):
        file = tmp_path / f"{number}.json"
        written(made.plan, file, lambda document, own=profile: document.update(zone_profile_m=own))
        with pytest.raises(ValueError, match=rf"{number}\.json is not a certified plan: the profile of the"):
            load_plan(file)
    with pytest.raises(ValueError, match=r"reaches 0 m across and 0.4 m up: both.* longer than 1e-09 m"):
        zone_of_profile(flat[0])
    with pytest.raises(ValueError, match=r"the profile of the zone reaches 0 m across and 0 m up"):
        zone_of_profile([])
    for number, wrong in enumerate(([[0.1]], [[-0.1, 1.0]], [["a", 1.0]], [[0.1, float("nan")]], 3)):
        file = tmp_path / f"wrong_{number}.json"
        written(made.plan, file, lambda document, own=wrong: document.update(zone_profile_m=own))
        with pytest.raises(ValueError, match=rf"wrong_{number}\.json is not a plan: zone_profile_m"):
            load_plan(file)


def test_what_cannot_be_proven_is_taken_as_not_certified(made: AvoidancePlan, tmp_path: Path) -> None:
    bare = written(replace(made.plan, zone_profile=()), tmp_path / "bare.json")
    with pytest.warns(UserWarning, match=r"bare\.json has no zone: treated as not certified"):
        assert not load_plan(bare).certified
    older = tmp_path / "older.json"
    document = json.loads(bare.read_text())
    older.write_text(json.dumps({key: one for key, one in document.items() if key != "checksum"}))
    with pytest.warns(UserWarning, match=r"older\.json has no checksum: treated as not certified"):
        assert not load_plan(older).certified


@pytest.mark.parametrize("zone", [ZONE, Ellipsoid(0.4, 0.7), Ellipsoid.around(ZONE)])
def test_the_profile_of_a_zone_is_read_as_it_is(zone: Zone) -> None:
    hull = zone_around(zone)
    corners = [(float(radius), float(height)) for radius, height in hull.profile]
    np.testing.assert_array_equal(zone_of_profile(corners).profile, hull.profile)


@pytest.mark.parametrize("certified", [True, False])
def test_a_plan_whose_reference_jumps_is_refused(tmp_path: Path, *, certified: bool) -> None:
    """Two vehicles that exchange places between two pieces are apart at every t, and no vehicle flies it."""
    ends = np.array([[-0.5, 0.0, 1.0, 0.0], [0.5, 0.0, 1.0, 0.0]])[:, :, None]  # (pieces, 4, 1)
    lengths = np.array([5.0, 5.0])
    plan = SwarmPlan(("cf1", "cf2"), (Trajectory(lengths, ends), Trajectory(lengths, ends[::-1])))
    assert certify(plan, ZONE).holds
    shown = as_certified(plan, zone_around(ZONE)) if certified else plan
    with pytest.raises(ValueError, match=r"position of cf1 jumps by 1 m within 1 s, maximum 0.001 m; write"):
        load_plan(written(shown, tmp_path / "plan.json"))
    still = Trajectory(lengths, np.stack([ends[1], ends[1] + 1e-4]))
    assert load_plan(written(SwarmPlan(("cf1",), (still,)), tmp_path / "still.json")).names == ("cf1",)


@pytest.mark.parametrize("row", [0, 3])
def test_steps_of_many_short_pieces_add_up(tmp_path: Path, row: int) -> None:
    """A thousand pieces of 1 us, each 0.9 mm or 0.9 mrad further: 0.9 m in a millisecond."""
    lengths = np.concatenate([[5.0], np.full(999, 1e-6), [5.0]])
    places = np.zeros((len(lengths), 4, 1))
    places[:, row, 0] = 9e-4 * np.arange(len(lengths))
    stairs, still = Trajectory(lengths, places), Trajectory(np.array([10.0]), np.full((1, 4, 1), 3.0))
    plan = SwarmPlan(("cf1", "cf2"), (stairs, still))
    with pytest.raises(ValueError, match=r"of cf1 jumps by 0.9 (m|rad) within 1 s, maximum 0.0"):
        load_plan(written(as_certified(plan, zone_around(ZONE)), tmp_path / "plan.json"))
    slow = Trajectory(np.full(20, 1.1), places[:20])
    assert load_plan(written(SwarmPlan(("cf1",), (slow,)), tmp_path / "slow.json")).names == ("cf1",)


def from_rest(peak: float, pause: float, turn: float) -> SwarmPlan:
    """Return x = peak (t^2 - t^3 / 3) to 2 s, then x falling alike, turned by `turn` [rad] after 2 s.

    Its velocity is peak (2 t - t^2) [m/s]: a first piece shorter by `pause` [s] does not end at rest.
    """
    away = np.zeros((2, 4, 4))
    away[:, 2, 0] = 1.0
    away[:, 0, 2:] = [[peak, -peak / 3.0], [-peak, peak / 3.0]]
    away[1, 3, 0] = turn
    end = 2.0 - pause
    away[1, 0, 0] = peak * (end**2 - end**3 / 3.0)
    return SwarmPlan(("cf1",), (Trajectory(np.array([end, 2.0]), away),))


@pytest.mark.parametrize("certified", [True, False])
def test_a_plan_whose_velocity_or_yaw_jumps_is_refused(tmp_path: Path, *, certified: bool) -> None:
    """Thrust and tilt are those of the acceleration inside pieces, which a step of the velocity is not in."""

    def read(plan: SwarmPlan) -> SwarmPlan:
        shown = as_certified(plan, zone_around(ZONE)) if certified else plan
        return load_plan(written(shown, tmp_path / "plan.json"))

    for plan in (from_rest(0.5, 0.0, 0.0), from_rest(0.5, 0.0, 2.0 * np.pi), from_rest(0.5, 0.0, -0.009)):
        assert read(plan).names == ("cf1",)
    with pytest.raises(ValueError, match=r"velocity of cf1 jumps by 0.375 m/s within 1 s, maximum 0.01 m"):
        read(from_rest(0.5, 0.5, 0.0))  # 0.5 (2 t - t^2) at t = 1.5 s
    with pytest.raises(ValueError, match=r"yaw of cf1 jumps by 3 rad within 1 s, maximum 0.01 r"):
        read(from_rest(0.5, 0.0, -3.0))
    for first, last in ((0.2, 0.0), (0.0, 0.2)):  # at rest before and after
        ends = np.zeros((1, 4, 3))
        ends[0, 0, 1:] = [first, 0.5 * (last - first)]
        with pytest.raises(ValueError, match=r"velocity of cf1 jumps by 0.2 m/s"):
            read(SwarmPlan(("cf1",), (Trajectory(np.array([1.0]), ends),)))


@pytest.mark.parametrize("reading", ["stop_and_go", "free"])
def test_plans_of_the_planner_have_no_steps(made: AvoidancePlan, reading: Reading) -> None:
    """Neighbouring pieces share their nodes' derivatives: what is left is rounding."""
    points = ((0.0, 0.0, 1.0), (1.0, 2.0, 1.5), (-2.0, 0.5, 0.5), (0.0, 0.0, 1.0))
    times, yaws = (0.0, 0.5, 7.0, 9.0), (0.0, 1.0, 7.0, -4.0)
    ways = (Waypoint(t, pos, yaw) for t, pos, yaw in zip(times, points, yaws, strict=True))
    for curve in (minimum_snap(VehicleWaypoints("cf1", tuple(ways)), reading), *made.plan.trajectories):
        assert max(largest_steps(curve)) < 1e-9


@pytest.mark.parametrize("certified", [True, False])
def test_a_plan_that_falls_without_thrust_is_refused(tmp_path: Path, *, certified: bool) -> None:
    """Controllers follow z = 2 - k (t^2 / 2 - t^3 / 1.5), at rest after 0.5 s, for a k of up to 0.95 g."""
    for k, falls in ((9.0, False), (9.4, True), (10.4, True)):
        fall = np.zeros((1, 4, 4))
        fall[0, 2] = [2.0, 0.0, -0.5 * k, k / 1.5]
        plan = SwarmPlan(("cf1",), (Trajectory(np.array([0.5]), fall),))
        shown = as_certified(plan, zone_around(ZONE)) if certified else plan
        file = written(shown, tmp_path / "plan.json")
        if falls:
            with pytest.raises(
                ValueError,
                match=r"plan\.json: cf1 needs an upward thrust of -?0\.0\d+ times.*; allow more time$",
            ):
                load_plan(file)
        else:
            assert load_plan(file).names == ("cf1",)
