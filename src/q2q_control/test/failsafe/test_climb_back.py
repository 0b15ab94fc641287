"""A vehicle measured again returns to the height of its setpoint before it follows it."""

from dataclasses import replace

import numpy as np
import pytest
from evading_flights import names_of
from resting_signals import resting_setpoint, resting_state

from q2q_control.failsafe.evasion.climb_back import BACK, LONGEST, ClimbBack, InFallback
from q2q_model.signals.values import SwarmSetpoint, SwarmState

TICK = 0.01
AWAY = (0.6, 0.1, 2.0)
"""Setpoint of the plan, which has moved on, not as far as one is led back from [m]."""
LOW = (0.3, 0.4, 0.5)
"""Where the vehicle is measured again [m]."""
SEEN = InFallback((), ())
LOST_CF1 = InFallback(("cf1",), ())
CUT = InFallback((), ("cf1",))


def state_of(*pos: tuple[float, float, float]) -> SwarmState:
    n = len(pos)
    return resting_state(0.0, names_of(n), np.array(pos))


def setpoint_of(t: float, *pos: tuple[float, float, float], climb: float = 0.0) -> SwarmSetpoint:
    n = len(pos)
    vel = np.tile([0.2, 0.1, climb], (n, 1))
    return resting_setpoint(t, names_of(n), np.array(pos), vel=vel)


def lost(*lost: str, climbs: ClimbBack) -> ClimbBack:
    climbs.update(setpoint_of(0.0, AWAY, AWAY), state_of(LOW, LOW), InFallback(lost, ()))
    return climbs


def test_it_climbs_where_it_is_measured_again_until_near_the_height_of_its_setpoint() -> None:
    climbs = lost("cf1", climbs=ClimbBack())
    for height in (LOW[2], 1.0, AWAY[2] - 1.01 * BACK):
        drifted = (LOW[0] + 0.1 * (height - LOW[2]), LOW[1], height)
        sent, names = climbs.update(setpoint_of(0.1 + height, AWAY, AWAY), state_of(drifted, AWAY), SEEN)
        assert names == {"cf1"}
        np.testing.assert_array_equal(sent.pos, [(*LOW[:2], AWAY[2]), AWAY])
        np.testing.assert_array_equal(sent.vel, [(0.0, 0.0, 0.0), (0.2, 0.1, 0.0)])
    given = setpoint_of(3.0, AWAY, AWAY)
    sent, names = climbs.update(given, state_of((*LOW[:2], AWAY[2] - 0.99 * BACK), AWAY), SEEN)
    assert not names
    assert sent is given
    assert not climbs.active


def test_it_sinks_where_it_is_as_well() -> None:
    climbs = lost("cf1", climbs=ClimbBack())
    sent, names = climbs.update(setpoint_of(0.1, (1.0, 0.0, 0.1)), state_of(LOW), SEEN)
    assert names == {"cf1"}
    np.testing.assert_array_equal(sent.pos, [(*LOW[:2], 0.1)])


@pytest.mark.parametrize("off", [False, True])
def test_who_was_always_measured_or_is_cut_follows_its_setpoint(off: bool) -> None:
    climbs = lost("cf1", climbs=ClimbBack()) if off else ClimbBack()
    given = setpoint_of(0.1, AWAY, AWAY)
    sent, names = climbs.update(given, state_of(LOW, LOW), CUT if off else SEEN)
    assert sent is given
    assert not names


def test_while_lost_it_keeps_its_setpoint() -> None:
    climbs = lost("cf1", climbs=ClimbBack())
    given = setpoint_of(0.1, AWAY, AWAY)
    sent, names = climbs.update(given, state_of(LOW, LOW), LOST_CF1)
    assert sent is given
    assert not names
    assert climbs.active


@pytest.mark.parametrize(("climb", "steady"), [(0.49, True), (0.51, False), (-0.49, True), (-0.51, False)])
def test_it_returns_while_its_setpoint_climbs_or_sinks_with_it_but_is_not_held(
    climb: float, steady: bool
) -> None:
    climbs = lost("cf1", climbs=ClimbBack())
    given = setpoint_of(0.1, LOW, climb=climb)
    sent, names = climbs.update(given, state_of(LOW), SEEN)
    assert names == (set() if steady else {"cf1"})
    assert sent is given


def test_a_climbing_one_is_held_sideways_and_climbs_as_it_is_sent() -> None:
    climbs = lost("cf1", climbs=ClimbBack())
    given = replace(setpoint_of(0.1, AWAY, climb=0.8), acc=np.array([[0.3, 0.4, 0.5]]))
    sent, _ = climbs.update(given, state_of(LOW), SEEN)
    np.testing.assert_array_equal(sent.vel, [[0.0, 0.0, 0.8]])
    np.testing.assert_array_equal(sent.acc, [[0.0, 0.0, 0.5]])


@pytest.mark.parametrize(("acc", "steady"), [(0.9, True), (1.1, False), (-1.1, False)])
def test_a_setpoint_that_turns_within_half_a_second_is_not_steady(acc: float, steady: bool) -> None:
    climbs = lost("cf1", climbs=ClimbBack())
    given = replace(setpoint_of(0.1, LOW), acc=np.array([[0.0, 0.0, acc]]))
    assert climbs.update(given, state_of(LOW), SEEN).names == (set() if steady else {"cf1"})


def test_one_that_cannot_climb_follows_its_setpoint_in_the_end() -> None:
    climbs = lost("cf1", climbs=ClimbBack())
    held = []
    for k in range(1, 500):
        given = setpoint_of(k * TICK, AWAY, AWAY)
        sent, _ = climbs.update(given, state_of(LOW, AWAY), SEEN)
        held.append(sent is not given)
    assert LONGEST == 3.5  # after which policies expect vehicles at their places
    assert sum(held) == pytest.approx(LONGEST / TICK, abs=1.5)
    assert not climbs.active


def test_once_at_its_height_it_is_led_back_to_a_setpoint_far_away() -> None:
    climbs, far = lost("cf1", climbs=ClimbBack()), (1.8, -1.6, 2.0)
    climbs.update(setpoint_of(0.1, far), state_of(LOW), SEEN)
    there = (*LOW[:2], far[2])
    sent, names = climbs.update(setpoint_of(0.2, far), state_of(there), SEEN)
    assert not names
    np.testing.assert_allclose(sent.pos, [there], atol=1e-12)
    assert climbs.active
    given = setpoint_of(3.0, far)
    assert climbs.update(given, state_of(there), SEEN).setpoint is given
    assert not climbs.active


def test_it_climbs_anew_after_each_loss_and_is_forgotten_if_it_leaves_the_state() -> None:
    climbs = lost("cf1", "cf2", climbs=ClimbBack())
    climbs.update(setpoint_of(0.1, AWAY, AWAY), state_of(LOW, AWAY), SEEN)
    climbs.update(setpoint_of(0.2, AWAY, AWAY), state_of(LOW, AWAY), LOST_CF1)
    there = (0.5, 0.5, 1.0)
    sent, _ = climbs.update(setpoint_of(0.3, AWAY, AWAY), state_of(there, AWAY), SEEN)
    np.testing.assert_array_equal(sent.pos[0], (*there[:2], AWAY[2]))
    alone = replace(state_of(LOW), names=("cf2",))
    _, names = climbs.update(setpoint_of(0.4, AWAY, AWAY), alone, SEEN)
    assert "cf1" not in names
