"""Wrong stamps and a clock that is set let the reference of a plan go on where it is."""

from copy import deepcopy

import numpy as np
import pytest
from played_room import ABOVE, GROUND, PLAN, STEP, PlayedRoom, frame, set_back

from q2q_model.trajectory.polynomials import setpoint_at
from q2q_planner.plan_playback.plan_player import PlanPlayer
from q2q_planner.plan_playback.transit import TransitParams


@pytest.mark.parametrize("off", [-1e9, -3.0, -0.5, 3.0, 1e9])
@pytest.mark.parametrize("called", [False, True])
def test_one_stamp_far_off_moves_no_plan(off: float, *, called: bool) -> None:
    player = PlanPlayer(PLAN, -1.0, TransitParams(), wait=False)
    player.update(frame(100.0, GROUND))
    if called:
        assert player.hold().granted
    played = player.played
    player.update(frame(100.0 + off, GROUND))
    player.update(frame(100.0 + STEP, GROUND))
    assert player.played == played


@pytest.mark.parametrize("off", [-100.0, -1.5, 1.5, 100.0])
def test_a_frame_far_off_gets_the_last_reference_under_its_stamp(off: float) -> None:
    for player in (PlanPlayer(PLAN, start, TransitParams(), wait=False) for start in (-1.0, 100.0)):
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
    player = PlanPlayer(PLAN, -1.0, TransitParams(), wait=False)
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
    player = PlanPlayer(PLAN, -1.0, TransitParams(), wait=False)
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
    player = PlanPlayer(PLAN, -1.0, TransitParams(), wait=False)
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
    first = PlanPlayer(PLAN, -1.0, TransitParams(), wait=False)
    for t in (100.0, 100.9, 101.8, 101.79):  # a late frame
        first.update(frame(t, GROUND))
    assert first.played is not None
    assert first.played.start == 100.0
    np.testing.assert_allclose(set_back(first, 0.0).pos, setpoint_at(PLAN, 0.1).pos, atol=1e-12)
    room, twin = PlayedRoom(ABOVE), PlayedRoom(ABOVE)
    for one in (room, twin):
        one.tick()
        assert one.player.transit().granted
        one.tick(1.0)
    again = set_back(room.player, 0.0)  # the time for which its stamps rise has passed
    np.testing.assert_allclose(again.pos, twin.tick(10 * STEP).pos, atol=1e-9)


@pytest.mark.parametrize("start", [-1.0, 100.0])
def test_a_clock_that_is_set_back_lets_what_was_called_go_on_without_a_wait_too(start: float) -> None:
    player = PlanPlayer(PLAN, start, TransitParams(), wait=False)
    for k in range(201):
        player.update(frame(100.0 + STEP * k, GROUND))
    assert player.hold().granted
    for t in (102.9, 103.8):
        held = player.update(frame(t, GROUND))
    for again in (set_back(player, 50.0), player.update(frame(51.0, GROUND))):
        np.testing.assert_array_equal(again.pos, held.pos)
    assert player.transit().granted
    player.update(frame(51.5, GROUND))
    twin = deepcopy(player)
    moving = twin.update(frame(51.6, GROUND))
    np.testing.assert_allclose(set_back(player, 10.0).pos, moving.pos, atol=1e-12)


def test_a_late_frame_lets_no_hold_and_no_transit_jump_back() -> None:
    player = PlanPlayer(PLAN, 0.0, TransitParams(), wait=False)
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
    assert player.transit().granted


def test_a_clock_that_is_set_back_by_less_than_a_late_frame_is_followed_once_it_goes_on() -> None:
    player = PlanPlayer(PLAN, 0.0, TransitParams(), wait=False)
    for t in (*(STEP * k for k in range(301)), *(2.5 + STEP * k for k in range(20))):
        before = player.update(frame(t, GROUND))
    assert player.hold().granted
    after = player.update(frame(before.t + STEP, GROUND))
    np.testing.assert_allclose(after.pos - before.pos, STEP * before.vel, atol=1e-4)


def test_a_late_frame_hides_no_outlier() -> None:
    room = PlayedRoom(ABOVE)
    room.tick(0.1)
    room.pos = ABOVE + np.array([[0.5, 0.5, 1.0], [0.0, 0.0, 0.0]])
    room.tick()
    room.player.update(frame(room.t - 0.5 * STEP, room.pos))
    assert "keep the vehicles at rest" in room.player.transit().reason
