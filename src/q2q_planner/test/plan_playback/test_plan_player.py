"""A plan is played at a stamp, at the first tick, or by calls; calls never let the reference jump."""

import numpy as np
import pytest
from played_room import ABOVE, GROUND, PLAN, STEP, PlayedRoom, first_points, frame

from q2q_model.node.reply import Reply
from q2q_model.signals.values import MocapFrame, SwarmSetpoint
from q2q_model.trajectory.polynomials import SwarmPlan
from q2q_planner.offline.minimum_snap.minimum_snap import minimum_snap_plan
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, Waypoint
from q2q_planner.plan_playback.plan_player import PlanPlayer
from q2q_planner.plan_playback.transit import TransitParams


def test_without_a_wait_the_plan_starts_at_the_first_tick_or_at_its_stamp() -> None:
    at_once = PlanPlayer(PLAN, -1.0, TransitParams(), wait=False)
    np.testing.assert_allclose(at_once.update(frame(7.0, GROUND)).pos, first_points(), atol=1e-12)
    assert at_once.played is not None
    assert at_once.played.start == 7.0
    late = PlanPlayer(PLAN, 3.0, TransitParams(), wait=False)
    np.testing.assert_allclose(late.update(frame(7.0, GROUND)).pos[0], [1.0, 0.0, 1.5], atol=1e-9)


@pytest.mark.parametrize("start", [0.0, 50.0])
def test_a_plan_with_a_stamp_does_not_wait_for_calls(start: float) -> None:
    with pytest.raises(ValueError, match=rf"start = {start:g} s and wait: .* give one of them"):
        PlanPlayer(PLAN, start, TransitParams(), wait=True)


def test_vehicles_held_at_the_first_points_start_no_plan_while_the_reference_follows_them() -> None:
    room = PlayedRoom(first_points())
    room.tick()
    message = "the reference follows the measured vehicles: transit first"
    assert (room.player.start().granted, room.player.start().reason) == (False, message)
    assert room.player.transit().granted
    room.tick(1.5)
    assert room.player.start().granted


def test_transit_start_hold_and_a_second_flight_never_let_the_reference_jump() -> None:
    room = PlayedRoom(ABOVE)
    room.tick()
    assert not room.player.start().granted  # not at the first points
    assert room.player.transit().granted
    room.tick(0.5)
    assert "moves at" in room.player.start().reason
    assert "hold first" in room.player.transit().reason
    np.testing.assert_allclose(room.tick(6.0).pos, first_points(), atol=1e-9)
    assert room.player.start().granted
    room.tick(3.0)
    assert room.player.hold().granted
    room.tick(1.0)
    assert np.abs(room.tick(1.0).vel).max() < 1e-9
    assert room.player.transit().granted  # restarted in flight: from the hold back to the first points
    np.testing.assert_allclose(room.tick(8.0).pos, first_points(), atol=1e-9)
    assert room.player.start().granted
    np.testing.assert_allclose(room.tick(9.0).pos[1], [0.0, -1.0, 1.5], atol=1e-9)
    assert room.largest_step() < 0.01  # 1 m/s: nothing here is faster


def turning(first: float, last: float) -> SwarmPlan:
    """Return a plan of one vehicle that turns where it is."""
    ways = Waypoint(0.0, (0.0, 0.0, 1.0), first), Waypoint(3.0, (0.0, 0.0, 1.0), last)
    return minimum_snap_plan([VehicleWaypoints("cf1", ways)])


def seen(player: PlanPlayer, seconds: tuple[float, float], yaw: float = 0.0) -> list[SwarmSetpoint]:
    """Return the references of a vehicle that is seen at (0, 0, 1) from one time to another [s]."""
    quat = np.array([[0.0, 0.0, np.sin(0.5 * yaw), np.cos(0.5 * yaw)]])
    times = np.arange(*seconds, STEP).tolist()
    return [player.update(MocapFrame(t, ("cf1",), np.array([[0.0, 0.0, 1.0]]), quat)) for t in times]


@pytest.mark.parametrize("turn", [1.5, -1.5])
def test_a_reference_that_turns_or_points_elsewhere_starts_no_plan_and_no_transit(turn: float) -> None:
    player = PlanPlayer(turning(0.0, turn), -1.0, TransitParams(), wait=True)
    seen(player, (0.0, 0.1))
    assert player.transit().granted
    seen(player, (0.1, 2.0))
    assert player.start().granted
    seen(player, (2.0, 3.5))
    assert "hold first" in player.start().reason
    assert "hold first" in player.transit().reason
    seen(player, (3.5, 6.0))
    assert (
        player.start().reason == "cf1's reference is 0.00 m and 1.50 rad from its first point: transit first"
    )
    assert player.transit().granted
    turned = seen(player, (6.0, 6.0 + 2.3))
    assert max(abs(float(one.yaw_rate[0])) for one in turned) <= 1.5 + 1e-9
    assert player.start().granted


def test_a_transit_turns_the_short_way_round() -> None:
    player = PlanPlayer(turning(-3.1, -3.1), -1.0, TransitParams(), wait=True)
    seen(player, (0.0, 0.1), 3.1)
    assert player.transit().granted
    rates = [abs(float(one.yaw_rate[0])) for one in seen(player, (0.1, 1.5), 3.1)]
    assert max(rates) == pytest.approx(1.5 * (2.0 * np.pi - 6.2), rel=1e-3)
    assert player.start().granted


def test_no_transit_begins_at_an_outlier() -> None:
    room = PlayedRoom(ABOVE)
    room.tick(0.1)
    room.pos = ABOVE + STEP * np.array([[1.26, -1.68, 0.0], [0.0, 0.0, 0.0]])
    room.tick()
    words = "a measured position has moved at 2.1 m/s since the frame before: keep the vehicles at rest"
    assert room.player.transit() == Reply(granted=False, reason=words)
    room.pos = ABOVE + STEP * np.array([[0.12, -0.16, 0.0], [0.0, 0.0, 0.0]])  # 1.9 m/s from there
    room.tick()
    assert room.player.transit().granted
