"""Minimum snap is exact: known costs, no better curve nearby, and the continuity its optimum must have."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from section_4_1 import SECTION_4_1

from q2q_model.trajectory.hermite import hermite_matrix, pieces_from_nodes
from q2q_model.trajectory.polynomials import Trajectory, derive
from q2q_planner.offline.minimum_snap.minimum_snap import (
    minimum_snap,
    minimum_snap_plan,
    plan_cost,
    snap_cost,
)
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, Waypoint

HOVER_ROUNDING = 1e-24
"""Snap of a hover at 3 m by rounding: (24 * 3 eps / T^4)^2 T is 3e-26 for T = 0.5 s; solving adds some."""


@st.composite
def vehicles(draw: st.DrawFn) -> VehicleWaypoints:
    count = draw(st.integers(2, 6))
    spans = draw(st.lists(st.floats(0.5, 10.0), min_size=count - 1, max_size=count - 1))
    number = st.floats(-3.0, 3.0)
    times = np.concatenate([[0.0], np.cumsum(spans)])
    return VehicleWaypoints(
        "cf1", tuple(Waypoint(float(t), draw(st.tuples(number, number, number)), draw(number)) for t in times)
    )


def jumps(trajectory: Trajectory, derivative: int) -> np.ndarray:
    """Return what a derivative jumps by at inner knots, (knots, 4)."""
    derived = derive(trajectory.coefficients, derivative)
    powers = trajectory.durations[:-1, None] ** np.arange(derived.shape[-1])
    return np.einsum("pak,pk->pa", derived[:-1], powers) - derived[1:, :, 0]


def test_section_4_1_costs_what_its_closed_form_says() -> None:
    closed_form = 100800.0 * (7.25 / 20**7 + 7.25 / 30**7 + 5.0 / 30**7 + 5.0 / 20**7)
    assert plan_cost(minimum_snap_plan(SECTION_4_1)) == pytest.approx(closed_form, rel=1e-12)  # rounding
    assert closed_form == pytest.approx(1.02115e-3, rel=2e-6)  # as printed in six digits


def test_the_hermite_matrix_of_snap_is_the_known_rest_to_rest_polynomial() -> None:
    assert hermite_matrix(4)[:, 4].tolist() == [0, 0, 0, 0, 35, -84, 70, -20]
    assert hermite_matrix(2)[:, 2].tolist() == [0, 0, 3, -2]


@given(vehicles())
def test_stop_and_go_passes_every_waypoint_at_rest(vehicle: VehicleWaypoints) -> None:
    trajectory = minimum_snap(vehicle)
    for waypoint in vehicle.waypoints:
        at = np.asarray(waypoint.t)
        # a degree-7 polynomial cancels about 3 digits at its end; the derivatives scale with 1 / T^p
        assert trajectory.at(at) == pytest.approx(np.array([*waypoint.pos, waypoint.yaw]), abs=1e-9)
        for p in (1, 2, 3):
            assert trajectory.at(at, p)[:3] == pytest.approx(0.0, abs=1e-9)
        assert trajectory.at(at, 1)[3] == pytest.approx(0.0, abs=1e-9)


@given(vehicles())
def test_the_free_optimum_passes_every_waypoint_and_is_smooth_to_order_six(vehicle: VehicleWaypoints) -> None:
    trajectory = minimum_snap(vehicle, "free")
    fastest = trajectory.durations.min()
    reached = np.array([trajectory.at(np.asarray(waypoint.t)) for waypoint in vehicle.waypoints])
    assert reached == pytest.approx(vehicle.points, abs=1e-8)
    size = max(1.0, float(np.abs(vehicle.points).max()))
    for derivative in range(1, 7):  # conditioning: end data of the shortest piece scale with T^-p
        bound = 1e-7 * size * np.exp(derivative) * max(1.0, fastest**-derivative)
        assert np.abs(jumps(trajectory, derivative)[:, :3]).max(initial=0.0) < bound
    for derivative in (1, 2):
        assert np.abs(jumps(trajectory, derivative)[:, 3]).max(initial=0.0) < 1e-7 * size * max(
            1.0, fastest**-2
        )


@given(vehicles(), st.integers(0, 2**32 - 1))
def test_no_smooth_curve_through_the_same_waypoints_costs_less(vehicle: VehicleWaypoints, seed: int) -> None:
    best = minimum_snap(vehicle, "free")
    wiggle = np.zeros((len(vehicle.waypoints), 4, 4))
    wiggle[1:-1, :, 1:] = np.random.default_rng(seed).normal(size=(len(vehicle.waypoints) - 2, 4, 3))
    added = pieces_from_nodes(wiggle, best.durations)
    added[:, 3] = 0.0  # yaw has its own, shorter end data
    other = Trajectory(best.durations, best.coefficients + 0.1 * added)
    assert snap_cost(other) >= snap_cost(best) * (1.0 - 1e-9) - HOVER_ROUNDING  # rounding of both sums
    assert snap_cost(best) <= snap_cost(minimum_snap(vehicle)) * (1.0 + 1e-9) + HOVER_ROUNDING


@settings(max_examples=20)
@given(vehicles())
def test_the_exact_cost_agrees_with_a_fine_sum(vehicle: VehicleWaypoints) -> None:
    trajectory = minimum_snap(vehicle, "free")
    steps = np.concatenate(
        [
            end - span + span * (np.arange(4000) + 0.5) / 4000
            for end, span in zip(np.cumsum(trajectory.durations), trajectory.durations, strict=True)
        ]
    )
    weights = np.repeat(trajectory.durations / 4000, 4000)
    density = (trajectory.at(steps, 4)[:, :3] ** 2).sum(axis=1) + trajectory.at(steps, 2)[:, 3] ** 2
    # the midpoint rule at 4000 points per piece is good to some 1e-7 of the largest term
    assert snap_cost(trajectory) == pytest.approx(float(weights @ density), rel=1e-5, abs=1e-12)


def test_times_may_be_whole_numbers_of_any_size() -> None:
    """600^7 is no integer of 64 bits."""
    slow = VehicleWaypoints("cf1", (Waypoint(0, (3, 0, 1)), Waypoint(600, (-3, 0, 1))))
    found = minimum_snap(slow)
    np.testing.assert_allclose(found.at(np.array([300.0, 600.0]))[:, 0], [0.0, -3.0], atol=1e-9)
    assert snap_cost(found) == pytest.approx(100_800.0 * 36.0 / 600.0**7, rel=1e-9)


def test_times_too_unequal_for_the_free_reading_name_the_vehicle_and_the_times() -> None:
    uneven = VehicleWaypoints(
        "cf1", tuple(Waypoint(t, (0.1 * t, 0, 1)) for t in (0.0, 32.12, 32.122, 332.0, 332.002, 700.0))
    )
    with pytest.raises(
        ValueError, match=r"cf1: times between waypoints from 0.002 to 367.998 s are too unequal"
    ):
        minimum_snap(uneven, "free")
    minimum_snap(uneven, "stop_and_go")


def cost_of(spans: tuple[float, ...]) -> float:
    """Return the cost of the free reading through 0, 1, 0, 1 .. m on x."""
    times = np.concatenate([[0.0], np.cumsum(spans)])
    ways = tuple(Waypoint(float(t), (float(k % 2), 0.0, 1.0)) for k, t in enumerate(times))
    return snap_cost(minimum_snap(VehicleWaypoints("cf1", ways), "free"))


def test_free_times_that_rounding_would_decide_are_refused_and_others_are_exact() -> None:
    """The costs are those of the optimality system of the coefficients, solved with 50 digits.

    The refused times gave 2e7 times the optimum, 2.21e-6.
    """
    with pytest.raises(ValueError, match=r"from 0.01 to 1000 s are too unequal for the reading free"):
        cost_of((466.26, 0.01, 1000.0))
    assert cost_of((1.0, 0.1, 30.0)) == pytest.approx(93311.6863698, rel=1e-10)
    assert cost_of((30.0, 0.1, 0.1, 30.0)) == pytest.approx(3521.00538541, rel=1e-10)


@pytest.mark.parametrize("place", [1, 150, 298])
def test_a_single_time_that_rounding_would_decide_is_found_among_hundreds(place: int) -> None:
    """It gives the system a few tiny eigenvalues, whose eigenvectors have few entries that are not small."""
    spans = np.full(300, 100.0)
    spans[place] = 0.002
    with pytest.raises(ValueError, match=r"from 0.002 to 100 s are too unequal for the reading free"):
        cost_of(tuple(spans))
    spans[place] = 1.0
    assert cost_of(tuple(spans)) > 0.0


def test_cost_is_the_sum_of_those_of_position_and_yaw() -> None:
    turning = VehicleWaypoints("cf1", (Waypoint(0, (0, 0, 0), 0.0), Waypoint(2, (1, 0, 0), 1.0)))
    trajectory = minimum_snap(turning)
    pos, yaw = 100800.0 / 2**7, 12.0 / 2**3
    assert snap_cost(trajectory) == pytest.approx(pos + yaw, rel=1e-12)
