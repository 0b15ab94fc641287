"""A transit is certified, as slow as told, and leads round what is in its way, or is refused."""

import numpy as np
import pytest

from q2q_model.geometry.zone import Cylinder
from q2q_model.signals.values import Array
from q2q_planner.offline.certificate.certificate import certify
from q2q_planner.offline.minimum_snap.flight_limits import peak_norm
from q2q_planner.plan_playback.transit import TransitParams, transit_plan

NAMES = ("cf1", "cf2")


def here(*rows: tuple[float, float, float]) -> Array:
    return np.array([(*row, 0.0) for row in rows])


@pytest.mark.parametrize(("yaw", "turn"), [(3.0, 2.0 * np.pi - 5.0), (-3.0, 1.0), (-1.4, -0.6)])
def test_a_transit_begins_and_ends_at_its_points_and_turns_the_short_way(yaw: float, turn: float) -> None:
    """It ends at a yaw of -2 rad, less than half a turn from the first, which counts up to full turns."""
    starts = np.array([[2.0, -1.0, 0.3, yaw], [1.4, 0.2, 0.4, 0.3]])
    ends = np.array([[1.1, -1.5, 1.2, -2.0], [1.9, 0.6, 0.9, -0.5]])
    first, second = transit_plan(NAMES, starts, ends, TransitParams()).trajectories
    assert starts[0, 3] == yaw  # the caller's array
    begin, end = first.at(np.array([0.0, first.duration]))
    np.testing.assert_allclose(begin[:3], starts[0, :3], atol=1e-12)
    assert begin[3] - yaw == pytest.approx(2.0 * np.pi * round((begin[3] - yaw) / (2.0 * np.pi)), abs=1e-12)
    assert end[3] - begin[3] == pytest.approx(turn)
    np.testing.assert_allclose(end, ends[0], atol=1e-9)
    np.testing.assert_allclose(second.at(np.array([0.0, second.duration])), [starts[1], ends[1]], atol=1e-9)


def test_a_transit_ends_where_it_should_is_as_slow_as_told_and_certified() -> None:
    ends = here((1.0, 0.0, 1.0), (0.0, 1.0, 1.5))
    plan = transit_plan(NAMES, here((0.0, 0.0, 0.5), (0.0, 1.0, 0.5)), ends, TransitParams())
    t = np.linspace(0.0, plan.duration, 500)
    speeds = [np.linalg.norm(curve.at(t, 1)[:, :3], axis=1).max() for curve in plan.trajectories]
    assert max(speeds) == pytest.approx(0.5, rel=1e-4)  # the longest line sets the time of all
    np.testing.assert_allclose([curve.at(t[-1:])[0] for curve in plan.trajectories], ends, atol=1e-9)
    assert plan.certified
    assert certify(plan, Cylinder(0.2, 1.1)).holds


@pytest.mark.parametrize("turn", [2.0, -2.0])
def test_a_turn_on_the_spot_keeps_its_yaw_rate(turn: float) -> None:
    start, end = np.array([[[2.0, -1.0, 1.0, 0.7]], [[2.0, -1.0, 1.0, 0.7 + turn]]])
    plan = transit_plan(("cf1",), start, end, TransitParams(transit_duration_min=0.1))
    rates = plan.trajectories[0].at(np.linspace(0.0, plan.duration, 1001), 1)[:, 3]
    assert abs(rates).max() == pytest.approx(1.5, rel=1e-5)


def test_lines_that_cross_are_flown_one_after_another() -> None:
    """Both lines meet at the origin in the middle; one at a time, 0.5 m stay between them."""
    starts, ends = here((-1.0, 0.0, 0.5), (0.0, -1.0, 0.5)), here((1.0, 0.0, 0.5), (0.0, 1.0, 0.5))
    plan = transit_plan(NAMES, starts, ends, TransitParams())
    assert certify(plan, Cylinder(0.2, 1.1)).holds
    half = plan.duration / 2
    moved = [float(np.ptp(curve.at(np.array([0.0, half])), axis=0).max()) for curve in plan.trajectories]
    assert sorted(round(one) for one in moved) == [0, 2]


def test_a_line_over_another_vehicle_becomes_a_way_around_it() -> None:
    """The way home after section 5.2: Q2 from -2 m to 2 m, over Q1 at rest in the middle."""
    starts, ends = here((0.0, 0.0, 1.5), (0.0, -2.0, 2.0)), here((0.0, 0.0, 1.5), (0.0, 2.0, 2.0))
    plan = transit_plan(NAMES, starts, ends, TransitParams())
    assert certify(plan, Cylinder(0.2, 1.1)).holds
    np.testing.assert_allclose(plan.trajectories[1].at(np.array(plan.duration)), ends[1], atol=1e-9)


def test_a_transit_that_no_order_keeps_apart_is_refused_with_pair_and_distance() -> None:
    stacked = here((0.0, 0.0, 1.0), (0.05, 0.0, 1.5))
    with pytest.raises(ValueError, match=r"cf1 and cf2 would enter each other's zone by 0\.\d\d m"):
        transit_plan(NAMES, here((0.0, 0.0, 0.5), (0.0, 1.0, 0.5)), stacked, TransitParams())


@pytest.mark.parametrize("speed", [0.5, 2.0, 5.0])
@pytest.mark.parametrize("length", [0.3, 1.0, 20.0])
def test_a_transit_keeps_its_speed_and_acceleration(speed: float, length: float) -> None:
    """Rest to rest, a long one peaks at the speed, a short one at 2 m/s^2."""
    here, there = np.array([[0.0, 0.0, 1.0, 0.0]]), np.array([[length, 0.0, 1.0, 0.0]])
    curve = transit_plan(
        ("cf1",), here, there, TransitParams(transit_speed=speed, transit_duration_min=0.1)
    ).trajectories[0]
    shares = peak_norm(curve, 1).value / speed, peak_norm(curve, 2).value / 2.0
    assert max(shares) == pytest.approx(1.0, rel=1e-5)  # the bound's own tolerance
