"""Positions are rounded by less than the bound, and conflicts behind cancelling coefficients are found."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from q2q_model.geometry.zone import Cylinder
from q2q_model.signals.values import Array
from q2q_model.trajectory.bernstein import control_points, split_in_half
from q2q_model.trajectory.polynomials import SwarmPlan, Trajectory, setpoint_at
from q2q_planner.offline.certificate.certificate import certify
from q2q_planner.offline.certificate.rounding_bound import (
    MOST_COEFFICIENTS,
    NOT_BOUNDED,
    ROUNDING,
    rounding_bound,
)
from q2q_planner.offline.certificate.shared_pieces import shared_pieces
from q2q_planner.offline.minimum_snap.minimum_snap import minimum_snap_plan
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, Waypoint


def along_x(coefficients: Array, duration: float) -> Trajectory:
    rows = np.zeros((1, 4, len(coefficients)))
    rows[0, 0] = coefficients
    return Trajectory(np.array([duration]), rows)


def beside_rest(coefficients: Array, duration: float) -> SwarmPlan:
    return SwarmPlan(("cf1", "cf2"), (along_x(coefficients, duration), along_x(np.zeros(3), duration)))


def exact(coefficients: Array, t: Fraction) -> Fraction:
    return sum((Fraction(float(c)) * t**k for k, c in enumerate(coefficients)), Fraction(0))


@pytest.mark.parametrize(
    ("q", "p", "duration"), [(94906265, 31635421, 0.7), (90000001, 30000001, 3.3), (67108859, 12345679, 0.9)]
)
@pytest.mark.parametrize("scale", [2.0**10, 2.0**20])
def test_vehicles_that_meet_behind_cancelling_coefficients_are_not_certified(
    q: int, p: int, duration: float, scale: float
) -> None:
    """(q t - p)^2 is zero at p / q alone; rounded, it stays 15 m and more from zero."""
    coefficients = scale * np.array([p * p, -2.0 * p * q, q * q])
    assert exact(coefficients, Fraction(p, q)) == 0
    proof = certify(beside_rest(coefficients, duration), Cylinder())
    assert not proof.holds
    assert proof.clearance <= -0.1  # that of vehicles that meet


@settings(deadline=None, max_examples=60)
@given(
    st.lists(st.floats(-1.0, 1.0), min_size=1, max_size=10),
    st.floats(0.0, 12.0),
    st.floats(0.01, 50.0),
    st.lists(st.floats(0.0, 1.0), min_size=1, max_size=6),
)
def test_control_points_and_setpoints_are_off_by_less_than_the_bound(
    numbers: list[float], digits: float, duration: float, cuts: list[float]
) -> None:
    coefficients = np.array(numbers) * 10.0**digits
    plan = beside_rest(coefficients, duration)
    bound = rounding_bound(plan.trajectories)
    shared = shared_pieces(plan.trajectories)
    points = control_points(shared.coefficients, shared.durations[:, None, None])[0, 0, 0]
    t, length = Fraction(0), Fraction(duration)
    for share in cuts:  # down to some stretch
        left, right = split_in_half(points)
        length /= 2
        t, points = (t, left) if share < 0.5 else (t + length, right)
        assert abs(Fraction(float(points[0])) - exact(coefficients, t)) <= bound
    when = duration * cuts[0]
    flown = setpoint_at(plan, when).pos[0, 0]
    assert abs(Fraction(float(flown)) - exact(coefficients, Fraction(when))) <= bound


def test_the_bound_grows_with_the_coefficients_and_ordinary_plans_need_none() -> None:
    curve = along_x(np.array([1.0, -20.0, 300.0]), 2.0)
    times_8 = Trajectory(curve.durations, 8.0 * curve.coefficients)
    assert rounding_bound([times_8]) == pytest.approx(8.0 * rounding_bound([curve]), rel=1e-12)
    across = VehicleWaypoints(
        "cf1", (Waypoint(0, (-2, 0, 1)), Waypoint(6, (2, 1, 1)), Waypoint(9, (0, 0, 2)))
    )
    assert rounding_bound(minimum_snap_plan([across], "free").trajectories) < ROUNDING


def test_a_jump_between_ends_that_count_as_one_time_is_part_of_the_bound() -> None:
    """Half a nanosecond apart, two ends are one cut; what a vehicle jumps there is seen by no stretch."""
    still, late = np.zeros((2, 4, 1)), np.zeros((2, 4, 1))
    late[1, 0, 0] = 3.0
    one, two = Trajectory(np.array([1.0, 1.0]), still), Trajectory(np.array([1.0 + 5e-10, 1.0]), late)
    assert rounding_bound([one, two]) > 3.0
    assert rounding_bound([one, Trajectory(np.array([1.0, 1.0]), late)]) < ROUNDING


def test_what_a_vehicle_flies_between_ends_that_count_as_one_time_is_part_of_the_bound() -> None:
    """At 4 km/s half a nanosecond is 2 um an axis."""
    flying = np.zeros((2, 4, 2))
    flying[:, 1, 1] = -4e3
    flying[1, 1, 0] = -4e3 * (1.0 + 5e-10)  # no jump
    ends = np.array([1.0 + 5e-10, 1.0])
    still = Trajectory(np.array([1.0, 1.0]), np.zeros((2, 4, 1)))
    bound = rounding_bound([still, Trajectory(ends, flying)])
    assert bound == pytest.approx(2.0 * np.sqrt(3.0) * 2e-6, rel=1e-4)  # of 4 km one bit is 1e-12


@pytest.mark.parametrize(
    ("coefficients", "duration"),
    [
        (np.array([1.0, 1e30, -1e30]), 1e30),  # sums that overflow
        (np.array([1.0, 5e-324]), 5e-324),  # a piece that no cut sees
        (np.array([1.0, 0.0]), 1e-9),
        (np.ones(MOST_COEFFICIENTS + 1), 1.0),
        (np.ones(2000), 1.0),
        (np.array([5.0, 1e14]), 1.0),  # rounded by metres
    ],
)
def test_a_plan_without_a_bound_is_not_certified(coefficients: Array, duration: float) -> None:
    proof = certify(beside_rest(coefficients, duration), Cylinder())
    assert not proof.holds
    assert proof.clearance == -np.inf
    assert proof.not_computed == NOT_BOUNDED
