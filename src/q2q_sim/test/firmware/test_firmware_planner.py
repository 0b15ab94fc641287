"""States of the high-level commander, and how it goes from one goal to the next."""

import math

import numpy as np
import pytest

from q2q_sim.firmware.commander.planner import Planner, PlannerResult, PlanState, Target, Vertical


def test_states_follow_the_commands() -> None:
    planner = Planner()
    planner.set_state(np.array([1.0, 2.0, 0.0]), np.zeros(3), 0.5)
    assert planner.goal(0.0) is None
    assert planner.take_off(Vertical(1.0, 2.0, 0.0), 10.0) == PlannerResult.OK
    assert planner.take_off(Vertical(1.0, 2.0, 0.0), 10.0) == PlannerResult.WRONG_STATE
    top = planner.goal(13.0)
    np.testing.assert_allclose(top.pos, [1.0, 2.0, 1.0])
    assert planner.land(Vertical(0.0, 2.0), 13.0) == PlannerResult.OK
    assert planner.land(Vertical(0.0, 2.0), 13.0) == PlannerResult.WRONG_STATE
    assert planner.goal(14.0).pos[2] == pytest.approx(0.5)
    assert planner.goal(15.0) is None
    assert planner.state == PlanState.IDLE


def test_go_to_starts_from_the_goal_of_the_moment_and_turns_the_shorter_way() -> None:
    planner = Planner()
    planner.go_to(Target((2.0, 0.0, 1.0), 3.0, 2.0), 0.0)
    before = planner.goal(1.0)
    planner.go_to(Target((0.0, 0.0, 1.0), -3.0, 2.0), 1.0)
    after = planner.goal(1.0)
    np.testing.assert_allclose(after.pos, before.pos, atol=1e-12)
    np.testing.assert_allclose(after.vel, before.vel, atol=1e-12)
    np.testing.assert_allclose(after.acc, before.acc, atol=1e-12)
    assert after.yaw == pytest.approx(before.yaw)
    end = planner.goal(3.0)
    assert end.yaw % (2 * math.pi) == pytest.approx(-3.0 % (2 * math.pi))
    assert abs(end.yaw - after.yaw) <= math.pi


def test_relative_and_linear_go_to() -> None:
    planner = Planner()
    planner.set_state(np.array([1.0, 1.0, 1.0]), np.zeros(3), 0.2)
    planner.go_to(Target((1.0, 0.0, 0.0), 0.3, 2.0, relative=True, linear=True), 0.0)
    middle = planner.goal(0.7)
    np.testing.assert_allclose(middle.pos, [1.35, 1.0, 1.0])
    np.testing.assert_allclose(middle.vel, [0.5, 0.0, 0.0], atol=1e-12)
    assert planner.goal(2.0).yaw == pytest.approx(0.5)


@pytest.mark.parametrize("asked", [math.pi, -math.pi])
def test_half_a_turn_is_flown_to_the_right_whichever_way_it_is_asked_for(asked: float) -> None:
    planner = Planner()
    planner.go_to(Target((0.0, 0.0, 1.0), float(np.float32(asked)), 2.0), 0.0)
    assert planner.goal(2.0).yaw == pytest.approx(-math.pi)
    assert planner.goal(1.0).yaw == pytest.approx(-math.pi / 2)


def test_a_goal_that_is_no_number_disables_the_planner_until_the_next_command() -> None:
    planner = Planner()
    assert planner.go_to(Target((1.0, 0.0, 1.0), 0.0, 0.0, linear=True), 0.0) == PlannerResult.OK
    assert planner.goal(0.01) is None
    assert planner.state == PlanState.DISABLED
    assert planner.take_off(Vertical(1.0, 1.0), 0.1) == PlannerResult.WRONG_STATE
    planner.go_to(Target((1.0, 0.0, 1.0), 0.0, 2.0), 0.1)
    np.testing.assert_allclose(planner.goal(3.0).pos, [1.0, 0.0, 1.0])
