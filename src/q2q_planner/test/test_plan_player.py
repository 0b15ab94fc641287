"""A plan is played at a stamp, at the first tick, or by calls; calls never let the reference jump."""

from copy import deepcopy

import numpy as np
import pytest

from q2q_model.signals.values import Array, MocapFrame, SwarmSetpoint
from q2q_model.trajectory.polynomials import SwarmPlan, setpoint_at
from q2q_planner.offline.minimum_snap.minimum_snap import minimum_snap_plan
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, Waypoint
from q2q_planner.plan_playback.braked_plan import brake_plan
from q2q_planner.plan_playback.glide import GlideParams
from q2q_planner.plan_playback.plan_player import PlanPlayer

NAMES = ("cf1", "cf2")
PLAN = minimum_snap_plan(
    [
        VehicleWaypoints("cf1", (Waypoint(0.0, (0.0, 0.0, 1.0)), Waypoint(4.0, (1.0, 0.0, 1.5)),
                                 Waypoint(8.0, (0.0, 0.0, 1.0)))),
        VehicleWaypoints("cf2", (Waypoint(0.0, (0.0, 1.0, 1.5)), Waypoint(8.0, (0.0, -1.0, 1.5)))),
    ]
)  # fmt: skip
GROUND = np.array([[0.1, 0.0, 0.0], [0.0, 1.1, 0.0]])
ABOVE = GROUND + np.array([0.0, 0.0, 0.5])
STEP = 0.01


class _Room:
    """Frames of vehicles that stay where they are put."""

    def __init__(self, pos: Array = GROUND) -> None:
        self.player = PlanPlayer(PLAN, -1.0, GlideParams(), wait=True)
        self.pos, self.t = pos, 100.0
        self.setpoints: list[SwarmSetpoint] = []

    def tick(self, seconds: float = STEP) -> SwarmSetpoint:
        for _ in range(round(seconds / STEP)):
            self.t += STEP
            self.setpoints.append(self.player.update(frame(self.t, self.pos)))
        return self.setpoints[-1]

    def largest_step(self) -> float:
        """Return how far the reference moved in one tick at most [m]."""
        pos = np.array([one.pos for one in self.setpoints])
        return float(np.linalg.norm(np.diff(pos, axis=0), axis=2).max())


def frame(t: float, pos: Array) -> MocapFrame:
    return MocapFrame(t, NAMES, pos, np.tile([0.0, 0.0, 0.0, 1.0], (len(pos), 1)))


def first_points() -> Array:
    return np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 1.5]])


def test_without_a_wait_the_plan_starts_at_the_first_tick_or_at_its_stamp() -> None:
    at_once = PlanPlayer(PLAN, -1.0, GlideParams(), wait=False)
    np.testing.assert_allclose(at_once.update(frame(7.0, GROUND)).pos, first_points(), atol=1e-12)
    assert at_once.played is not None
    assert at_once.played.start == 7.0
    late = PlanPlayer(PLAN, 3.0, GlideParams(), wait=False)
    np.testing.assert_allclose(late.update(frame(7.0, GROUND)).pos[0], [1.0, 0.0, 1.5], atol=1e-9)


@pytest.mark.parametrize("start", [0.0, 50.0])
def test_a_plan_with_a_stamp_does_not_wait_for_calls(start: float) -> None:
    with pytest.raises(ValueError, match=rf"start {start:g} s with wait: .* give one of them"):
        PlanPlayer(PLAN, start, GlideParams(), wait=True)


def test_while_it_waits_the_reference_is_where_the_vehicles_are_seen() -> None:
    room = _Room()
    np.testing.assert_array_equal(room.tick().pos, GROUND)
    room.pos = ABOVE
    np.testing.assert_array_equal(room.tick(5.0).pos, room.pos)
    assert room.player.played is None


def test_a_vehicle_missing_from_a_frame_rests_where_it_was_last_seen() -> None:
    player = PlanPlayer(PLAN, -1.0, GlideParams(), wait=True)
    player.update(frame(0.0, GROUND))
    alone = MocapFrame(0.1, PLAN.names[:1], ABOVE[:1], np.array([[0.0, 0.0, 0.0, 1.0]]))
    np.testing.assert_array_equal(player.update(alone).pos, [ABOVE[0], *GROUND[1:]])


def test_a_vehicle_that_was_never_seen_has_no_reference_and_is_named() -> None:
    player = PlanPlayer(PLAN, -1.0, GlideParams(), wait=True)
    with pytest.raises(ValueError, match="cf2 has not been measured"):
        player.update(MocapFrame(0.0, ("cf1",), GROUND[:1], np.array([[0.0, 0.0, 0.0, 1.0]])))
    assert player.glide().reason == "no vehicle has been measured yet"


def test_vehicles_held_at_the_first_points_start_no_plan_while_the_reference_follows_them() -> None:
    room = _Room(first_points())
    room.tick()
    message = "the reference follows the measured vehicles: glide first"
    assert (room.player.start().granted, room.player.start().reason) == (False, message)
    assert room.player.glide().granted
    room.tick(1.5)
    assert room.player.start().granted


def test_glide_start_hold_and_a_second_flight_never_let_the_reference_jump() -> None:
    room = _Room(ABOVE)
    room.tick()
    assert not room.player.start().granted  # not at the first points
    assert room.player.glide().granted
    room.tick(0.5)
    assert "moves at" in room.player.start().reason
    assert "hold first" in room.player.glide().reason
    np.testing.assert_allclose(room.tick(6.0).pos, first_points(), atol=1e-9)
    assert room.player.start().granted
    room.tick(3.0)
    assert room.player.hold().granted
    room.tick(1.0)
    assert np.abs(room.tick(1.0).vel).max() < 1e-9
    assert room.player.glide().granted  # restarted in flight: from the hold back to the first points
    np.testing.assert_allclose(room.tick(8.0).pos, first_points(), atol=1e-9)
    assert room.player.start().granted
    np.testing.assert_allclose(room.tick(9.0).pos[1], [0.0, -1.0, 1.5], atol=1e-9)
    assert room.largest_step() < 0.01  # 1 m/s: nothing here is faster


@pytest.mark.parametrize("held", [False, True])
def test_no_vehicle_in_flight_is_left_to_drift_by_a_wait(held: bool) -> None:
    """Both fly 3 cm below their references; the same without the wait is the truth."""
    rooms = _Room(ABOVE), _Room(ABOVE)
    for room in rooms:
        room.tick()
        assert room.player.glide().granted
        room.tick(1.0)
        if held:
            assert room.player.hold().granted
            room.tick(2.0)
        room.pos = room.setpoints[-1].pos - np.array([0.0, 0.0, 0.03])
        room.tick()
    refusal = rooms[0].player.wait()
    assert not refusal.granted
    assert refusal.reason == (
        "cf1 is 0.03 m from its reference: in flight it would drift; "
        "hold, or land it first; call wait_landed if it stands there"
    )
    for _ in range(50):
        waited, flown = (room.tick() for room in rooms)
        np.testing.assert_array_equal(waited.pos, flown.pos)


def test_vehicles_that_have_landed_are_followed_again_by_a_wait_and_one_that_has_not_refuses_it() -> None:
    room = _Room(ABOVE)
    room.tick()
    assert room.player.glide().granted
    flying = room.tick(8.0).pos
    room.pos = np.array([GROUND[0], flying[1]])
    room.tick()
    assert "cf2 is 0.00 m from its reference" in room.player.wait().reason
    room.pos = GROUND
    room.tick()
    assert room.player.wait().granted
    np.testing.assert_array_equal(room.tick().pos, GROUND)


@pytest.mark.parametrize(("ground", "height"), [(0.0, 0.2), (0.2, 0.4)])
def test_vehicles_found_on_the_ground_are_followed_after_a_flight_however_low(
    ground: float, height: float
) -> None:
    """On the floor, and on a table 0.2 m high."""
    ways = Waypoint(0.0, (0.0, 0.0, height)), Waypoint(3.0, (0.5, 0.0, height))
    player = PlanPlayer(minimum_snap_plan([VehicleWaypoints("cf1", ways)]), -1.0, GlideParams(), wait=True)
    level = np.array([[0.0, 0.0, 0.0, 1.0]])
    flown = MocapFrame(0.0, ("cf1",), np.array([[0.0, 0.0, height]]), level)
    landed = MocapFrame(9.0, ("cf1",), np.array([[0.0, 0.0, ground]]), level)
    player.update(flown)
    assert player.glide().granted
    player.update(landed)
    assert "wait_landed if it stands there" in player.wait().reason
    assert player.wait_landed().granted
    np.testing.assert_array_equal(player.update(landed).pos, landed.pos)


def turning(first: float, last: float) -> SwarmPlan:
    """Return a plan of one vehicle that turns where it is."""
    ways = Waypoint(0.0, (0.0, 0.0, 1.0), first), Waypoint(3.0, (0.0, 0.0, 1.0), last)
    return minimum_snap_plan([VehicleWaypoints("cf1", ways)])


def seen(player: PlanPlayer, seconds: tuple[float, float], yaw: float = 0.0) -> list[SwarmSetpoint]:
    """Return the references of a vehicle that is seen at (0, 0, 1) from one time to another [s]."""
    quat = np.array([[0.0, 0.0, np.sin(0.5 * yaw), np.cos(0.5 * yaw)]])
    times = np.arange(*seconds, STEP).tolist()
    return [player.update(MocapFrame(t, ("cf1",), np.array([[0.0, 0.0, 1.0]]), quat)) for t in times]


def test_a_reference_that_turns_or_points_elsewhere_starts_no_plan_and_no_glide() -> None:
    player = PlanPlayer(turning(0.0, 1.5), -1.0, GlideParams(), wait=True)
    seen(player, (0.0, 0.1))
    assert player.glide().granted
    seen(player, (0.1, 2.0))
    assert player.start().granted
    seen(player, (2.0, 3.5))
    assert "hold first" in player.start().reason
    assert "hold first" in player.glide().reason
    seen(player, (3.5, 6.0))
    assert player.start().reason == "cf1's reference is 0.00 m and 1.50 rad from its first point: glide first"
    assert player.glide().granted
    turned = seen(player, (6.0, 6.0 + 2.3))
    assert max(abs(float(one.yaw_rate[0])) for one in turned) <= 1.5 + 1e-9
    assert player.start().granted


def test_a_glide_turns_the_short_way_round() -> None:
    player = PlanPlayer(turning(-3.1, -3.1), -1.0, GlideParams(), wait=True)
    seen(player, (0.0, 0.1), 3.1)
    assert player.glide().granted
    rates = [abs(float(one.yaw_rate[0])) for one in seen(player, (0.1, 1.5), 3.1)]
    assert max(rates) == pytest.approx(1.5 * (2.0 * np.pi - 6.2), rel=1e-3)
    assert player.start().granted


def test_no_glide_begins_at_an_outlier() -> None:
    room = _Room(ABOVE)
    room.tick(0.1)
    room.pos = ABOVE + np.array([[0.5, 0.5, 1.0], [0.0, 0.0, 0.0]])
    room.tick()
    assert "keep the vehicles at rest" in room.player.glide().reason
    room.pos = ABOVE
    room.tick(2 * STEP)
    assert room.player.glide().granted


def set_back(player: PlanPlayer, to: float) -> SwarmSetpoint:
    """Return the reference in which the player follows a clock set back to a time [s]."""
    return [player.update(frame(to + STEP * k, GROUND)) for k in range(11)][-1]


@pytest.mark.parametrize("off", [-1e9, -3.0, -0.5, 3.0, 1e9])
@pytest.mark.parametrize("called", [False, True])
def test_one_stamp_far_off_moves_no_plan(off: float, *, called: bool) -> None:
    player = PlanPlayer(PLAN, -1.0, GlideParams(), wait=False)
    player.update(frame(100.0, GROUND))
    if called:
        assert player.hold().granted
    played = player.played
    player.update(frame(100.0 + off, GROUND))
    player.update(frame(100.0 + STEP, GROUND))
    assert player.played == played


@pytest.mark.parametrize("off", [-100.0, -1.5, 1.5, 100.0])
def test_a_frame_far_off_gets_the_last_reference_under_its_stamp(off: float) -> None:
    for player in (PlanPlayer(PLAN, start, GlideParams(), wait=False) for start in (-1.0, 100.0)):
        player.update(frame(100.0, GROUND))
        last = player.update(frame(100.9, GROUND))
        wrong = player.update(frame(100.9 + off, GROUND))
        assert wrong.t == 100.9 + off
        np.testing.assert_array_equal(wrong.pos, last.pos)
        np.testing.assert_array_equal(wrong.vel, last.vel)


def frames_ahead_and_back(player: PlanPlayer, began: float, size: float) -> None:
    """Play on from a stamp [s] while the clock is ahead by a size [s] for 0.2 s, and for 0.2 s as it was."""
    for k in range(40):
        player.update(frame(began + STEP * k + (size if k < 20 else 0.0), GROUND))


@pytest.mark.parametrize("size", [1.0, 5.5])
@pytest.mark.parametrize("called", [False, True])
def test_frames_ahead_that_come_back_move_no_plan_that_began_before(size: float, *, called: bool) -> None:
    player = PlanPlayer(PLAN, -1.0, GlideParams(), wait=False)
    player.update(frame(100.0, GROUND))
    if called:
        assert player.hold().granted
    played = player.played
    assert played is not None
    frames_ahead_and_back(player, 100.01, size)
    assert player.played is not None
    assert player.played.start == pytest.approx(played.start + 0.12)  # in which steps were not accepted yet
    set_back(player, 90.0)  # the step ahead is forgotten
    assert player.played.start == (pytest.approx(100.12 - 10.4) if called else 90.0)


@pytest.mark.parametrize("called", [False, True])
def test_a_step_of_the_clock_ahead_lets_the_reference_go_on(*, called: bool) -> None:
    player = PlanPlayer(PLAN, -1.0, GlideParams(), wait=False)
    player.update(frame(100.0, GROUND))
    for k in range(1, 201):
        last = player.update(frame(100.0 + STEP * k, GROUND))
    if called:
        assert player.hold().granted
    ahead = [player.update(frame(105.0 + STEP * k, GROUND)) for k in range(12)]
    for one in ahead[:11]:
        np.testing.assert_allclose(one.pos, last.pos, atol=1e-12)
    step = ahead[11].pos - last.pos
    np.testing.assert_allclose(step, STEP * last.vel, atol=1e-3)


def test_what_is_called_while_a_clock_is_ahead_comes_back_with_it() -> None:
    player = PlanPlayer(PLAN, -1.0, GlideParams(), wait=False)
    player.update(frame(100.0, GROUND))
    for k in range(20):
        player.update(frame(105.5 + STEP * k, GROUND))
    assert player.hold().granted  # at 105.69
    set_back(player, 100.2)
    assert player.played is not None
    assert player.played.start == pytest.approx(100.2)


def test_a_clock_that_is_set_back_starts_the_plan_of_the_first_tick_anew_and_lets_a_called_one_go_on() -> (
    None
):
    first = PlanPlayer(PLAN, -1.0, GlideParams(), wait=False)
    for t in (100.0, 100.9, 101.8, 101.79):  # a late frame
        first.update(frame(t, GROUND))
    assert first.played is not None
    assert first.played.start == 100.0
    np.testing.assert_allclose(set_back(first, 0.0).pos, setpoint_at(PLAN, 0.1).pos, atol=1e-12)
    room, twin = _Room(ABOVE), _Room(ABOVE)
    for one in (room, twin):
        one.tick()
        assert one.player.glide().granted
        one.tick(1.0)
    again = set_back(room.player, 0.0)  # the time for which its stamps rise has passed
    np.testing.assert_allclose(again.pos, twin.tick(10 * STEP).pos, atol=1e-9)


@pytest.mark.parametrize("start", [-1.0, 100.0])
def test_a_clock_that_is_set_back_lets_what_was_called_go_on_without_a_wait_too(start: float) -> None:
    player = PlanPlayer(PLAN, start, GlideParams(), wait=False)
    for k in range(201):
        player.update(frame(100.0 + STEP * k, GROUND))
    assert player.hold().granted
    for t in (102.9, 103.8):
        held = player.update(frame(t, GROUND))
    for again in (set_back(player, 50.0), player.update(frame(51.0, GROUND))):
        np.testing.assert_array_equal(again.pos, held.pos)
    assert player.glide().granted
    player.update(frame(51.5, GROUND))
    twin = deepcopy(player)
    gliding = twin.update(frame(51.6, GROUND))
    np.testing.assert_allclose(set_back(player, 10.0).pos, gliding.pos, atol=1e-12)


def test_a_late_frame_lets_no_hold_and_no_glide_jump_back() -> None:
    player = PlanPlayer(PLAN, 0.0, GlideParams(), wait=False)
    for k in range(301):
        before = player.update(frame(STEP * k, GROUND))
    late = player.update(frame(2.5, GROUND))
    np.testing.assert_array_equal(late.pos, setpoint_at(PLAN, 2.5).pos)
    assert player.hold().granted
    after = player.update(frame(3.0 + STEP, GROUND))
    np.testing.assert_allclose(
        after.pos - before.pos, STEP * before.vel, atol=1e-4
    )  # a / 2 STEP^2, < 2 m/s^2
    np.testing.assert_allclose(after.vel, before.vel, atol=2.0 * STEP)
    for t in (3.9, 4.5, 3.8):  # the last one late, while it still braked
        player.update(frame(t, GROUND))
    assert player.glide().granted


def test_a_hold_that_is_called_again_while_it_brakes_brakes_as_the_first_one_does() -> None:
    once, often = (PlanPlayer(PLAN, 0.0, GlideParams(), wait=False) for _ in range(2))
    for player in (once, often):
        player.update(frame(3.0, GROUND))
        assert player.hold().reason == "at rest in 1.0 s"
    for k in range(1, 21):
        t = 3.0 + 0.1 * k
        np.testing.assert_array_equal(often.update(frame(t, GROUND)).acc, once.update(frame(t, GROUND)).acc)
        assert often.hold().reason == f"at rest in {max(1.0 - 0.1 * k, 0.0):.1f} s"
    assert often.glide().granted
    often.update(frame(5.5, GROUND))
    assert often.hold().reason == "at rest in 1.0 s"  # it brakes the glide


def test_a_clock_that_is_set_back_by_less_than_a_late_frame_is_followed_once_it_goes_on() -> None:
    player = PlanPlayer(PLAN, 0.0, GlideParams(), wait=False)
    for t in (*(STEP * k for k in range(301)), *(2.5 + STEP * k for k in range(20))):
        before = player.update(frame(t, GROUND))
    assert player.hold().granted
    after = player.update(frame(before.t + STEP, GROUND))
    np.testing.assert_allclose(after.pos - before.pos, STEP * before.vel, atol=1e-4)


def test_a_late_frame_hides_no_outlier() -> None:
    room = _Room(ABOVE)
    room.tick(0.1)
    room.pos = ABOVE + np.array([[0.5, 0.5, 1.0], [0.0, 0.0, 0.0]])
    room.tick()
    room.player.update(frame(room.t - 0.5 * STEP, room.pos))
    assert "keep the vehicles at rest" in room.player.glide().reason


def test_a_braked_plan_begins_as_the_plan_goes_and_stays_on_its_path() -> None:
    stopping = brake_plan(PLAN, 3.8)  # across the waypoint at 4 s
    for curve, whole in zip(stopping.trajectories, PLAN.trajectories, strict=True):
        tau = np.linspace(0.0, 1.0, 201)
        s = 3.8 + tau - 0.5 * tau**2
        np.testing.assert_allclose(curve.at(tau), whole.at(s), atol=1e-9)
        np.testing.assert_allclose(curve.at(np.array(0.0), 1), whole.at(np.array(3.8), 1), atol=1e-9)
        np.testing.assert_allclose(curve.at(np.array(1.0), 1), 0.0, atol=1e-6)


@pytest.mark.parametrize(
    ("s", "end"), [(-1.0, 0.0), (-0.3, 0.0), (0.0, 0.0), (0.1, 0.6), (7.9, 8.0), (8.0, 8.0), (20.0, 8.0)]
)
def test_braking_ends_half_its_duration_later_in_the_plan_or_at_its_ends(s: float, end: float) -> None:
    for curve, whole in zip(brake_plan(PLAN, s).trajectories, PLAN.trajectories, strict=True):
        np.testing.assert_allclose(curve.at(np.array(5.0)), whole.at(np.array(end)), atol=1e-9)


@pytest.mark.parametrize("t", [4.7, 40.0])
def test_vehicles_held_before_or_after_their_plan_are_at_rest_already(t: float) -> None:
    player = PlanPlayer(PLAN, 5.0, GlideParams(), wait=False)
    rest = player.update(frame(t, GROUND))
    assert player.hold().reason == "at rest in 0.0 s"
    np.testing.assert_array_equal(player.update(frame(t + 0.4, GROUND)).pos, rest.pos)
