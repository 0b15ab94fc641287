"""A hold brakes on the path of the plan, and is no other when it is called again."""

import numpy as np
import pytest
from played_room import GROUND, PLAN, frame

from q2q_planner.plan_playback.braked_plan import brake_plan
from q2q_planner.plan_playback.plan_player import PlanPlayer
from q2q_planner.plan_playback.transit import TransitParams


def test_a_hold_that_is_called_again_while_it_brakes_brakes_as_the_first_one_does() -> None:
    once, often = (PlanPlayer(PLAN, 0.0, TransitParams(), wait=False) for _ in range(2))
    for player in (once, often):
        player.update(frame(3.0, GROUND))
        assert player.hold().reason == "at rest in 1.0 s"
    for k in range(1, 21):
        t = 3.0 + 0.1 * k
        np.testing.assert_array_equal(often.update(frame(t, GROUND)).acc, once.update(frame(t, GROUND)).acc)
        assert often.hold().reason == f"at rest in {max(1.0 - 0.1 * k, 0.0):.1f} s"
    assert often.transit().granted
    often.update(frame(5.5, GROUND))
    assert often.hold().reason == "at rest in 1.0 s"  # it brakes the transit


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
    player = PlanPlayer(PLAN, 5.0, TransitParams(), wait=False)
    rest = player.update(frame(t, GROUND))
    assert player.hold().reason == "at rest in 0.0 s"
    np.testing.assert_array_equal(player.update(frame(t + 0.4, GROUND)).pos, rest.pos)
