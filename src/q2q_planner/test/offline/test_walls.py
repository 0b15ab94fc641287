"""Plans stay within the walls of a room by proof, at every time, or say who is in the way."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.polynomial import Polynomial

from q2q_model.geometry.zone import Cylinder
from q2q_model.trajectory.polynomials import SwarmPlan, Trajectory
from q2q_planner.commands.plan import main
from q2q_planner.offline.avoidance import joint_plan
from q2q_planner.offline.avoidance.avoidance_params import AvoidanceParams
from q2q_planner.offline.avoidance.joint_plan import AvoidancePlan, avoid_zones
from q2q_planner.offline.avoidance.waypoint_checks import InfeasibleError
from q2q_planner.offline.certificate import certificate
from q2q_planner.offline.certificate.branch_and_bound import TOLERANCE
from q2q_planner.offline.minimum_snap.minimum_snap import minimum_snap_plan, plan_cost
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, Waypoint
from q2q_planner.offline.walls import Walls, prove_within

ZONE = Cylinder(0.2, 1.1)
HEAD_ON = (
    VehicleWaypoints("cf1", (Waypoint(0, (-1.0, 0.0, 1.0)), Waypoint(8, (1.0, 0.0, 1.0)))),
    VehicleWaypoints("cf2", (Waypoint(0, (1.0, 0.0, 1.0)), Waypoint(8, (-1.0, 0.0, 1.0)))),
)
"""Two vehicles that pass each other 0.2 m apart: 0.1 m to the side each, if nothing is in the way."""
NARROW = (-1.5, -0.04, 0.5, 1.5, 1.0, 1.5)
"""A wall 4 cm to one side of their path."""


def held(walls: tuple[float, ...]) -> AvoidancePlan:
    return avoid_zones(HEAD_ON, ZONE, params=AvoidanceParams(within=walls))


def sampled(plan: SwarmPlan) -> np.ndarray:
    t = np.linspace(0.0, plan.duration, 20_001)
    return np.stack([curve.at(t)[:, :3] for curve in plan.trajectories])  # (n, T, 3)


@settings(deadline=None, max_examples=50)
@given(st.integers(0, 10**6))
def test_the_proven_distance_is_that_of_the_extrema(seed: int) -> None:
    """Of random polynomials of degree 7 it is the least at ends and roots of the derivative, to 10 um."""
    generator = np.random.default_rng(seed)
    durations = generator.uniform(0.5, 2.0, 2)
    curves = [Trajectory(durations, generator.normal(scale=0.1, size=(2, 4, 8))) for _ in range(2)]
    walls = Walls((-1.0, -2.0, -3.0), (2.0, 1.0, 3.0))
    proof = prove_within(SwarmPlan(("cf1", "cf2"), tuple(curves)), walls)
    least = np.inf
    for curve in curves:
        for piece, length in enumerate(durations):
            for axis in range(3):
                p = Polynomial(curve.coefficients[piece, axis])
                roots = p.deriv().roots()
                real = roots.real[(abs(roots.imag) < 1e-9) & (roots.real > 0.0) & (roots.real < length)]
                values = p(np.array([0.0, length, *real]))
                least = min(least, values.min() - walls.low[axis], walls.high[axis] - values.max())
    assert least - 2.0 * TOLERANCE <= proof.clearance <= least


def test_a_plan_is_deformed_away_from_a_wall_that_it_would_cross() -> None:
    """Without the wall both give way by 0.1 m, with it one by 4 cm at most, for every t and by samples."""
    free = avoid_zones(HEAD_ON, ZONE).plan
    assert sampled(free)[..., 1].min() == pytest.approx(-0.1, abs=5e-3)
    found = held(NARROW)
    pos = sampled(found.plan)
    assert found.wall_proof is not None
    assert found.wall_proof.holds
    assert 0.0 < found.wall_proof.clearance < 1e-3  # as near to the wall as pays
    assert pos[..., 1].min() > -0.04
    assert ZONE.signed_distance(pos[0] - pos[1]).min() > 0.0
    assert found.plan.certified
    assert found.cost > avoid_zones(HEAD_ON, ZONE).cost


def test_a_wall_that_is_far_changes_nothing() -> None:
    far, free = held((-9.0, -9.0, 0.0, 9.0, 9.0, 9.0)), avoid_zones(HEAD_ON, ZONE)
    assert np.array_equal(sampled(far.plan), sampled(free.plan))
    assert far.wall_proof is not None
    assert far.wall_proof.clearance == pytest.approx(1.0, abs=1e-6)  # the floor


def test_one_vehicle_alone_is_kept_within_the_walls() -> None:
    """Minimum snap through the corner of an L swings out by some centimetres."""
    corner = [Waypoint(0, (0, 0, 1)), Waypoint(2, (1, 0, 1)), Waypoint(3, (1, 1, 1)), Waypoint(5, (0, 1, 1))]
    alone = (VehicleWaypoints("cf1", tuple(corner)),)
    box = (-0.01, -0.01, 0.5, 1.01, 1.01, 1.5)
    assert not prove_within(minimum_snap_plan(alone, "free"), Walls(box[:3], box[3:])).holds
    found = avoid_zones(alone, ZONE, "free", AvoidanceParams(within=box))
    assert found.wall_proof is not None
    assert found.wall_proof.holds


@pytest.mark.parametrize("slower", [1.0, 3.0, 9.0])
def test_a_way_that_sweeps_along_several_walls_is_found(slower: float) -> None:
    """Minimum snap swings out by metres; straight lines are among the ways, so there is one within."""
    places = ((-0.95, 0.26, 1.83), (1.89, -0.01, 1.71), (-1.44, -0.11, 1.02), (-1.36, -1.31, 1.0))
    way = map(Waypoint, slower * np.array([0.0, 4.47, 5.22, 7.54]), places)
    alone = (VehicleWaypoints("cf1", tuple(way)),)
    box = (-2.05, -2.05, 0.45, 2.05, 2.05, 2.05)
    found = avoid_zones(alone, ZONE, "free", AvoidanceParams(within=box))
    assert (sampled(found.plan) > box[:3]).all()
    assert (sampled(found.plan) < box[3:]).all()
    assert found.cost < plan_cost(minimum_snap_plan(alone))


@pytest.mark.parametrize("end", [5.3, 6.0, 7.1])
def test_a_wall_that_is_crossed_between_samples_only_is_left(end: float) -> None:
    """The samples are milliseconds apart and the curve is 0.1 um beyond the wall for less than that."""
    points = ((0.0, 0.0, 1.0), (1.0, 0.0, 1.0), (1.0, 1.0, 1.0), (0.0, 1.0, 1.0))
    corner = map(Waypoint, (0.0, 2.0, 3.0, end), points)
    alone = (VehicleWaypoints("cf1", tuple(corner)),)
    free = minimum_snap_plan(alone, "free")
    box = (-9.0, -9.0, 0.0, sampled(free)[..., 0].max() - 1e-7, 9.0, 9.0)
    assert not prove_within(free, Walls(box[:3], box[3:])).holds
    found = avoid_zones(alone, ZONE, "free", AvoidanceParams(within=box))
    assert sampled(found.plan)[..., 0].max() < box[3]
    assert found.cost < found.infimum * (1.0 + 1e-5)  # it moves by the margin, 0.2 mm


@pytest.mark.parametrize("walls", [(), (-1.6, -1.6, 0.3, 1.6, 1.6, 2.3)])
def test_a_zone_that_is_entered_between_samples_only_names_the_pair(walls: tuple[float, ...]) -> None:
    """The last waypoints touch the zone's edge, and no sample before them is near it."""
    ways = {
        "cf1": [(-0.6, -0.1, 1.6), (0.1, 1.2, 1.3), (1.3, 1.3, 1.2)],
        "cf2": [(1.4, 0.4, 1.3), (0.2, 0.7, 1.5), (1.3, 1.2, 2.0)],
    }
    swarm = [
        VehicleWaypoints(name, tuple(map(Waypoint, (0.0, 4.0, 8.0), rows))) for name, rows in ways.items()
    ]
    with pytest.raises(InfeasibleError, match="cf1 and cf2 cannot be kept apart: "):
        avoid_zones(swarm, Cylinder(0.1, 1.1), "free", AvoidanceParams(within=walls))


def test_a_corridor_that_is_too_narrow_and_a_waypoint_outside_are_named() -> None:
    with pytest.raises(
        InfeasibleError,
        match=r"cf1 and cf2 cannot be kept apart within the walls: 0\.1\d+ m inside each other's zone at t = "
        r".*, and apart without walls; move the walls outwards, or reduce the zone$",
    ):
        held((-1.5, -0.02, 0.5, 1.5, 0.02, 1.5))
    with pytest.raises(InfeasibleError, match=r"cf1, waypoint 0 is 0.5 m beyond a wall; must be within"):
        held((-0.5, -1.0, 0.5, 1.5, 1.0, 1.5))
    with pytest.raises(InfeasibleError, match=r"cf1, waypoint 0 lies on a wall; must be within"):
        held((-1.0, -1.0, 0.5, 1.5, 1.0, 1.5))
    with pytest.raises(ValueError, match="must be finite and in increasing order"):
        Walls((-1.0, -1.0, 0.0), (1.0, 1.0, float("inf")))


def test_a_plan_without_walls_is_searched_only_where_its_answer_is_said(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(certificate, "MOST_STRETCHES", 1)
    monkeypatch.setattr(joint_plan, "_holds_without_walls", lambda *_: pytest.fail("searched"))
    with pytest.raises(InfeasibleError, match="no pair is proven to stay apart"):
        held(NARROW)


@pytest.mark.parametrize(
    ("walls", "words"),
    [
        ((1.0, 2.0), "has 2 numbers; must have 6"),
        ((1.0, 0.0, 0.0, 1.0, 1.0, 1.0), "must be finite and in increasing order"),
        ((0.0, 0.0, 0.0, 1.0, 1.0, float("nan")), "must be finite numbers"),
        ((0.0, 0.0, 0.0, 1.0, 1.0, float("inf")), "must be finite numbers"),
    ],
)
def test_walls_that_are_no_box_are_refused(walls: tuple[float, ...], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        held(walls)


def test_the_command_says_and_writes_the_proof(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    ways, out, facts = tmp_path / "w.yaml", tmp_path / "plan.json", tmp_path / "facts.json"
    ways.write_text(
        "vehicles:\n  cf1: [{t: 0, pos: [-1, 0, 1]}, {t: 8, pos: [1, 0, 1]}]\n"
        "  cf2: [{t: 0, pos: [1, 0, 1]}, {t: 8, pos: [-1, 0, 1]}]\n"
    )
    asked = [str(ways), "--out", str(out), "--json", str(facts), "--eps", "0.2"]
    box = [str(value) for value in NARROW]
    assert main([*asked, "--within", *box]) == 0
    printed = capsys.readouterr().out
    assert "certified out of the zone for every t; smallest distance to it 0." in printed
    assert "certified within the walls for every t; smallest distance to one 0." in printed
    output = json.loads(facts.read_text())
    assert output["within"] is output["certified"] is True
    assert 0.0 < output["wall_clearance_m"] < 1e-3
    box[1] = "0.05"
    assert main([*asked, "--within", *box]) == 1
    assert "cf1, waypoint 0 is 0.05 m beyond a wall" in capsys.readouterr().err
    box[1] = "nan"
    with pytest.raises(SystemExit):
        main([*asked, "--within", *box])
    assert "argument --within: nan; must be a finite number" in capsys.readouterr().err


@pytest.mark.parametrize("higher", [0.0, 0.02])
def test_vehicles_that_meet_in_a_corridor_pass_over_each_other(higher: float) -> None:
    swarm = [
        VehicleWaypoints("a", (Waypoint(0, (0, 0, 1)), Waypoint(5, (2, 0, 1 + higher)))),
        VehicleWaypoints("b", (Waypoint(0, (2, 0, 1)), Waypoint(5, (0, 0, 1)))),
    ]
    params = AvoidanceParams(within=(-0.1, -0.02, 0.2, 2.1, 0.02, 2.5))
    found = avoid_zones(swarm, Cylinder(0.1, 0.3), params=params)
    assert found.certificate.holds
    assert found.wall_proof is not None
    assert found.wall_proof.holds
    assert found.cost < 1.3 * found.infimum
