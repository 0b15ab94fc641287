"""Allocated times keep the limits, thrust is checked for every t, flatness gives the right attitude."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from q2q_model.trajectory.flatness import flat_state
from q2q_model.vehicle.attitude_limits import LEAST_THRUST, TILT_MAX, YAW_RATE_MAX
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, CRAZYFLIE_2_1, GRAVITY
from q2q_planner.offline.minimum_snap.feasibility import check_feasible, plan_peaks
from q2q_planner.offline.minimum_snap.flight_limits import (
    FlightLimits,
    allocate_times,
    peak_norm,
    peak_tilt,
    peak_yaw_rate,
    with_limits_of,
)
from q2q_planner.offline.minimum_snap.minimum_snap import minimum_snap, minimum_snap_plan
from q2q_planner.offline.minimum_snap.waypoint_document import swarm_from_document
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, Waypoint

LIMITS = FlightLimits(speed=1.5, acceleration=3.0)


@settings(deadline=None, max_examples=40)
@given(st.integers(0, 10**6), st.sampled_from(["stop_and_go", "free"]))
@example(87, "free")
def test_allocated_times_keep_the_limits_and_waste_little(seed: int, reading: str) -> None:
    generator = np.random.default_rng(seed)
    points = [Waypoint(0.0, tuple(generator.uniform(-2.0, 2.0, 3))) for _ in range(generator.integers(2, 6))]
    trajectory = minimum_snap(allocate_times("cf1", points, LIMITS, reading), reading)
    speed, acc = peak_norm(trajectory, 1).value, peak_norm(trajectory, 2).value
    assert speed <= LIMITS.speed * (1.0 + 1e-5)  # the bound's own tolerance
    assert acc <= LIMITS.acceleration * (1.0 + 1e-5)
    if len(points) == 2:  # one piece: one of the two limits is met, but for rounding up to a tick
        assert speed > 0.95 * LIMITS.speed or acc > 0.95 * LIMITS.acceleration


@settings(deadline=None, max_examples=40)
@given(st.integers(0, 10**6))
def test_the_peak_is_above_every_sample_and_at_the_largest(seed: int) -> None:
    generator = np.random.default_rng(seed)
    points = tuple(Waypoint(float(t), tuple(generator.normal(size=3))) for t in (0.0, 1.0, 3.0))
    trajectory = minimum_snap(VehicleWaypoints("cf1", points), "free")
    t = np.linspace(0.0, 3.0, 20_001)
    seen = np.linalg.norm(trajectory.at(t, 2)[:, :3], axis=1)
    peak = peak_norm(trajectory, 2)
    assert seen.max() <= peak.value <= seen.max() * (1.0 + 1e-4)  # TOLERANCE, and 0.15 ms between samples
    assert np.linalg.norm(trajectory.at(np.asarray(peak.t), 2)[:3]) == pytest.approx(peak.value, rel=1e-4)


def test_more_thrust_than_there_is_names_vehicle_waypoint_and_bound() -> None:
    steep = [
        VehicleWaypoints("cf1", (Waypoint(0, (0, 0, 1)), Waypoint(5, (1, 0, 1)), Waypoint(5.6, (1, 0, 2))))
    ]
    with pytest.raises(
        ValueError, match=r"cf1, after waypoint 1 .*N of thrust, but crazyflie_2_0 has at most 0.439 N"
    ):
        check_feasible(minimum_snap_plan(steep), steep, CRAZYFLIE_2_0)
    calm = [VehicleWaypoints("cf1", (Waypoint(0, (0, 0, 1)), Waypoint(5, (1, 0, 2))))]
    check_feasible(minimum_snap_plan(calm), calm, CRAZYFLIE_2_0)


@settings(deadline=None, max_examples=40)
@given(st.integers(0, 10**6), st.sampled_from(["stop_and_go", "free"]))
def test_allocated_times_keep_the_yaw_rate(seed: int, reading: str) -> None:
    """By samples of the trajectory; a turn on the spot takes 3/2 of the turn over the rate, and a tick."""
    generator = np.random.default_rng(seed)
    places, yaws = generator.choice([0.0, 0.3], (4, 3)), generator.uniform(-9.0, 9.0, 4)
    points = [Waypoint(0.0, tuple(pos), float(yaw)) for pos, yaw in zip(places, yaws, strict=True)]
    timed = allocate_times("cf1", points, LIMITS, reading)
    trajectory = minimum_snap(timed, reading)
    rate = np.abs(trajectory.at(np.linspace(0.0, trajectory.duration, 5001), 1)[:, 3])
    assert rate.max() <= YAW_RATE_MAX * (1.0 + 1e-6)
    assert 1.0 - 1e-12 <= peak_yaw_rate(trajectory).value / rate.max() <= 1.0 + 1e-4
    spot = allocate_times("cf1", [replace(points[0], yaw=1.0), replace(points[0], yaw=-2.0)], LIMITS, reading)
    assert spot.times[1] == pytest.approx(1.5 * 3.0 / YAW_RATE_MAX, abs=0.01)


def test_a_turn_too_fast_names_vehicle_waypoint_and_rate() -> None:
    """A turn by 90 "degrees" in 10 s peaks at 3/2 of 9 rad/s, in its middle."""
    points = (Waypoint(0, (0, 0, 1)), Waypoint(5, (1, 0, 1)), Waypoint(15, (1, 0, 1), yaw=90.0))
    wrong = [VehicleWaypoints("cf1", points)]
    with pytest.raises(
        ValueError, match=r"cf1, after waypoint 1 \(t = 10.00 s\): turns at 13.5 rad/s, maximum 3.5 rad/s"
    ):
        check_feasible(minimum_snap_plan(wrong), wrong, CRAZYFLIE_2_0)
    right = [VehicleWaypoints("cf1", (*points[:2], replace(points[2], yaw=np.pi / 2)))]
    check_feasible(minimum_snap_plan(right), right, CRAZYFLIE_2_0)


def test_a_hover_without_a_time_is_refused() -> None:
    points = [Waypoint(0.0, (0, 0, 1)), Waypoint(0.0, (1, 0, 1)), Waypoint(0.0, (1, 0, 1))]
    with pytest.raises(ValueError, match="cf1, waypoint 2: pos and yaw equal those of the previous waypoint"):
        allocate_times("cf1", points, LIMITS)


def hop(period: float, across: float = 0.0) -> list[VehicleWaypoints]:
    """Return one metre up and down, passing the top, in a time [s]; its top may be moved aside [m]."""
    places = (0.0, 0.0, 1.0), (0.0, across, 2.0), (0.0, 0.0, 1.0)
    points = (Waypoint(0.5 * period * row, pos) for row, pos in enumerate(places))
    return [VehicleWaypoints("cf1", tuple(points))]


@pytest.mark.parametrize("across", [0.0, 1e-3])
def test_a_fall_that_controllers_cannot_command_names_vehicle_waypoint_and_bound(across: float) -> None:
    """Moved aside by a millimetre the fall tilts as well; it is the thrust that is named."""
    height = minimum_snap(hop(1.8)[0], "free").at(np.array(0.9), 2)[2]
    assert height < -GRAVITY
    with pytest.raises(
        ValueError,
        match=r"cf1, after waypoint [01] \(t = 0.90 s\): needs an upward thrust of -0.057 times the weight, "
        r"controllers command at least 0.05; allow more time",
    ):
        check_feasible(minimum_snap_plan(hop(1.8, across), "free"), hop(1.8, across), CRAZYFLIE_2_1)


def test_the_fastest_hop_that_is_accepted_leaves_the_least_thrust() -> None:
    """Accelerations grow with 1 / T^2, so the shortest period follows from the one of a hop in 1.8 s."""
    fall = -minimum_snap(hop(1.8)[0], "free").at(np.array(0.9), 2)[2]
    shortest = 1.8 * np.sqrt(fall / ((1.0 - LEAST_THRUST) * GRAVITY))
    slower, faster = hop(shortest * 1.0001), hop(shortest * 0.9999)
    check_feasible(minimum_snap_plan(slower, "free"), slower, CRAZYFLIE_2_1)
    assert plan_peaks(minimum_snap_plan(slower, "free")).tilt == 0.0
    with pytest.raises(ValueError, match=r"upward thrust of 0.05 times the weight"):
        check_feasible(minimum_snap_plan(faster, "free"), faster, CRAZYFLIE_2_1)


def test_thrust_that_points_straight_down_is_a_right_angle() -> None:
    assert peak_tilt(minimum_snap(hop(1.8)[0], "free")).value == pytest.approx(0.5 * np.pi)


@settings(deadline=None, max_examples=40)
@given(st.integers(0, 10**6), st.floats(0.3, 3.0))
def test_the_peak_tilt_is_that_of_the_flat_attitude(seed: int, duration: float) -> None:
    """It is above every sample and at the largest; thrust that points down counts as a right angle."""
    generator = np.random.default_rng(seed)
    points = tuple(Waypoint(duration * t, tuple(generator.normal(size=3))) for t in (0.0, 1.0, 3.0))
    trajectory = minimum_snap(VehicleWaypoints("cf1", points), "free")
    acc = trajectory.at(np.linspace(0.0, 3.0 * duration, 20_001), 2)
    flat = flat_state(acc[:, :3], acc[:, 3])
    leans = np.arccos(np.clip(np.cos(flat.roll) * np.cos(flat.pitch), -1.0, 1.0))
    seen = np.where(acc[:, 2] + GRAVITY > 0.0, leans, np.pi / 2.0).max()
    assert seen - 1e-7 <= peak_tilt(trajectory).value <= seen * (1.0 + 1e-3)  # between samples


def test_more_tilt_than_controllers_command_names_vehicle_waypoint_and_bound() -> None:
    """One metre in 0.95 s peaks at 84 sqrt(5) / 25 / 0.95^2 m/s^2 to the side, in 1.5 s at 0.33 rad."""
    quick = [VehicleWaypoints("cf1", (Waypoint(0, (0, 0, 1)), Waypoint(0.95, (1, 0, 1))))]
    tilt = np.arctan(84.0 * np.sqrt(5.0) / 25.0 / 0.95**2 / GRAVITY)
    with pytest.raises(
        ValueError,
        match=rf"cf1, after waypoint 0 .* tilts by {tilt:.3g} rad, but controllers by at most 0.35",
    ):
        check_feasible(minimum_snap_plan(quick), quick, CRAZYFLIE_2_1)
    slow = [VehicleWaypoints("cf1", (Waypoint(0, (0, 0, 1)), Waypoint(1.5, (1, 0, 1))))]
    check_feasible(minimum_snap_plan(slow), slow, CRAZYFLIE_2_1)
    check_feasible(minimum_snap_plan(quick), quick, CRAZYFLIE_2_0, tilt_max=0.8)


def test_the_peaks_of_a_plan_are_those_of_its_fastest_vehicle() -> None:
    """One metre from rest to rest in T: 35 / 16 / T and 84 sqrt(5) / 25 / T^2."""
    swarm = [
        VehicleWaypoints(f"cf{k}", (Waypoint(0, (0, k, 1)), Waypoint(t, (1, k, 1))))
        for k, t in ((1, 2.0), (2, 5.0))
    ]
    speed, acceleration, tilt = plan_peaks(minimum_snap_plan(swarm))
    assert speed == pytest.approx(35.0 / 16.0 / 2.0, rel=1e-3)
    assert acceleration == pytest.approx(84.0 * np.sqrt(5.0) / 25.0 / 4.0, rel=1e-3)
    assert tilt == pytest.approx(np.arctan(acceleration / GRAVITY), rel=1e-3)


def test_limits_are_cut_to_what_thrust_and_tilt_allow() -> None:
    """An acceleration of g sin(tilt) tilts the thrust by no more in any direction, and by that in one."""
    spare = CRAZYFLIE_2_0.rpyt_thrust_max / CRAZYFLIE_2_0.mass - GRAVITY
    most = [with_limits_of(FlightLimits(acceleration=50.0), one) for one in (CRAZYFLIE_2_0, CRAZYFLIE_2_1)]
    assert most[0].acceleration == pytest.approx(min(spare, most[1].acceleration))
    turn = np.linspace(0.0, 2.0 * np.pi, 10_001)
    acc = most[1].acceleration * np.array([np.cos(turn), np.sin(turn)])
    assert np.arctan2(acc[0], acc[1] + GRAVITY).max() == pytest.approx(TILT_MAX, rel=1e-6)
    strong = replace(CRAZYFLIE_2_1, full_pwm_thrust=10.0, thrust_max=10.0)
    fall = with_limits_of(FlightLimits(acceleration=50.0, tilt=1.5), strong).acceleration
    assert fall == pytest.approx((1.0 - LEAST_THRUST) * GRAVITY)


def test_a_document_without_times_gets_them_and_one_with_times_keeps_them() -> None:
    document = {
        "vehicles": {
            "cf1": [{"pos": [0, 0, 1]}, {"pos": [3, 0, 1], "yaw": 1.0}],
            "cf2": [{"t": 0, "pos": [0, 2, 1]}, {"t": 9, "pos": [3, 2, 1]}],
        }
    }
    first, second = swarm_from_document(document, LIMITS)
    assert first.times[1] == pytest.approx(35.0 / 16.0 * 3.0 / 1.5, abs=0.011)  # rounded up to a tick
    assert first.waypoints[1].yaw == 1.0
    assert second.times.tolist() == [0.0, 9.0]


@given(st.tuples(*[st.floats(-5.0, 5.0)] * 3), st.floats(-3.0, 3.0))
def test_the_flat_attitude_points_the_thrust_along_the_force(acc: tuple, yaw: float) -> None:
    """Put roll and pitch into (4)-(6) and get the acceleration back."""
    flat = flat_state(np.array(acc), np.array(yaw))
    phi, theta, psi = flat.roll, flat.pitch, yaw
    ux = np.cos(phi) * np.sin(theta) * np.cos(psi) + np.sin(phi) * np.sin(psi)
    uy = np.cos(phi) * np.sin(theta) * np.sin(psi) - np.sin(phi) * np.cos(psi)
    uz = np.cos(phi) * np.cos(theta)
    back = flat.thrust * np.array([ux, uy, uz]) - [0.0, 0.0, GRAVITY]
    assert back == pytest.approx(np.array(acc), abs=1e-9)


def test_hover_is_level_at_one_g() -> None:
    flat = flat_state(np.zeros(3), np.array(0.7))
    assert (flat.thrust, flat.roll, flat.pitch) == (GRAVITY, 0.0, 0.0)
