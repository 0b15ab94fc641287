"""A plan is read the same for one vehicle and for all, and rests outside its time."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from q2q_model.signals.values import SetpointStatus
from q2q_model.trajectory.polynomials import SwarmPlan, Trajectory, setpoint_at
from q2q_planner.offline.minimum_snap.minimum_snap import minimum_snap_plan
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, Waypoint


def swarm(seed: int) -> SwarmPlan:
    generator = np.random.default_rng(seed)
    vehicles = []
    for name in ("cf1", "cf2", "cf3"):
        times = np.concatenate([[0.0], np.cumsum(generator.uniform(0.5, 3.0, generator.integers(1, 5)))])
        points = [
            Waypoint(float(t), tuple(generator.normal(size=3)), float(generator.normal())) for t in times
        ]
        vehicles.append(VehicleWaypoints(name, tuple(points)))
    return minimum_snap_plan(vehicles, "free")


@settings(deadline=None)  # the first call compiles
@given(st.integers(0, 10**6), st.floats(-5.0, 20.0))
def test_the_swarm_is_read_as_each_vehicle_by_itself(seed: int, t: float) -> None:
    plan = swarm(seed)
    setpoint = setpoint_at(plan, t + 3.0, start=3.0)
    when = np.asarray(t + 3.0 - 3.0)
    for row, trajectory in enumerate(plan.trajectories):
        assert setpoint.pos[row] == pytest.approx(trajectory.at(when)[:3], abs=1e-12)
        assert setpoint.vel[row] == pytest.approx(trajectory.at(when, 1)[:3], abs=1e-12)
        assert setpoint.acc[row] == pytest.approx(trajectory.at(when, 2)[:3], abs=1e-11)
        assert setpoint.yaw[row] == pytest.approx(trajectory.at(when)[3], abs=1e-12)
        assert setpoint.yaw_rate[row] == pytest.approx(trajectory.at(when, 1)[3], abs=1e-12)


@settings(deadline=None)  # the first call compiles
@given(st.integers(0, 10**6), st.floats(0.01, 0.99))
def test_velocity_and_acceleration_are_the_derivatives_of_position(seed: int, share: float) -> None:
    plan = swarm(seed)
    t, h = share * plan.duration, 1e-5
    before, here, after = (setpoint_at(plan, t + k * h) for k in (-1, 0, 1))
    jerk_bound = 1e6 * h  # a jump of a higher derivative within the stencil
    assert (after.pos - before.pos) / (2 * h) == pytest.approx(here.vel, abs=1e-4 + jerk_bound * h)
    assert (after.vel - before.vel) / (2 * h) == pytest.approx(here.acc, abs=1e-3 + jerk_bound * h)


def test_a_curve_of_many_pieces_has_not_come_to_rest_at_its_own_duration() -> None:
    """A sum of twelve lengths depends on its order in the last bit; the pieces end at the running one."""
    generator = np.random.default_rng(0)
    for _ in range(100):
        lengths = generator.uniform(0.1, 3.0, 12)
        steady = np.zeros((12, 4, 2))
        steady[:, 0, 0], steady[:, 0, 1] = np.cumsum(lengths) - lengths, 1.0
        line = Trajectory(lengths, steady)
        assert line.at(np.array([line.duration]), 1)[0, 0] == 1.0
        assert setpoint_at(SwarmPlan(("cf1",), (line,)), line.duration).vel[0, 0] == 1.0


def test_a_plan_rests_before_its_start_and_after_each_end() -> None:
    line = Trajectory(np.array([2.0]), np.array([[[1.0, 3.0], [0.0, 0.0], [0.0, -1.0], [0.5, 0.25]]]))
    still = Trajectory(np.array([4.0]), np.zeros((1, 4, 2)))
    plan = SwarmPlan(("cf1", "cf2"), (line, still))
    early, late = setpoint_at(plan, 9.0, start=10.0), setpoint_at(plan, 13.0, start=10.0)
    assert early.pos[0].tolist() == [1.0, 0.0, 0.0]
    assert late.pos[0].tolist() == [7.0, 0.0, -2.0]
    assert late.yaw.tolist() == [1.0, 0.0]
    assert not early.vel.any()
    assert not late.vel.any()
    assert late.yaw_rate.tolist() == [0.0, 0.0]
    assert late.t == 13.0
    assert (late.status == SetpointStatus.NOMINAL).all()


def test_a_plan_without_vehicles_or_with_one_name_twice_is_refused() -> None:
    curve = Trajectory(np.array([1.0]), np.zeros((1, 4, 1)))
    with pytest.raises(ValueError, match="0 names for 0 trajectories"):
        SwarmPlan((), ())
    with pytest.raises(ValueError, match="each vehicle needs its own"):
        SwarmPlan(("cf1", "cf1"), (curve, curve))


@pytest.mark.parametrize(
    ("durations", "coefficients", "message"),
    [
        (np.array([0.0]), np.zeros((1, 4, 2)), "above 0 s"),
        (np.array([1.0]), np.full((1, 4, 2), np.nan), "not finite"),
        (np.array([1.0]), np.zeros((1, 3, 2)), r"expected \(pieces,\)"),
        (np.array([]), np.zeros((0, 4, 2)), "at least one piece"),
    ],
)
def test_a_trajectory_that_is_none_is_refused(
    durations: np.ndarray, coefficients: np.ndarray, message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        Trajectory(durations, coefficients)
