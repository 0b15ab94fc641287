"""A setpoint that is not finite is announced, stops its vehicle, and touches no other motion."""

from dataclasses import replace

import numpy as np
import pytest
from resting_signals import resting_setpoint, resting_state

from q2q_model.signals.values import Array, SetpointStatus, SwarmSetpoint, SwarmState
from q2q_planner.online.safe.motion.motion_propagation import at_reference, propagate
from q2q_planner.online.safe.motion.safe_replanner_params import SafeReplannerParams
from q2q_planner.online.safe.nonfinite_setpoints import flyable_inputs, moves_finitely
from q2q_planner.online.safe.safe_replanner import SafeReplanner

TICK, SPEED = 0.01, 1.0
PARAMS = SafeReplannerParams(eps=0.2, tracking=0.02)
JERKS = pytest.mark.parametrize("jerk_max", [0.0, 20.0])
BROKEN, NOMINAL = SetpointStatus.PROMISE_BROKEN, SetpointStatus.NOMINAL
NAMES = ("cf1", "cf2")


def apart(k: int) -> SwarmSetpoint:
    """Return two vehicles that fly along y at SPEED, 9 m apart."""
    return along(k, 9.0)


def along(k: int, x: float) -> SwarmSetpoint:
    pos, vel = np.array([[0.0, 0.0, 1.0], [x, 0.0, 1.0]]), np.tile([0.0, SPEED, 0.0], (2, 1))
    yaw = np.array([0.3, -0.4])
    return resting_setpoint(k * TICK, NAMES, pos + vel * k * TICK, vel=vel, yaw=yaw)


def without(setpoint: SwarmSetpoint, name: str, row: int = 0) -> SwarmSetpoint:
    """Return the setpoint with NaN in a row of one of its fields."""
    values = getattr(setpoint, name).copy()
    values[row] = np.nan
    return replace(setpoint, **{name: values})


def seen(setpoint: SwarmSetpoint, pos: Array) -> SwarmState:
    return resting_state(setpoint.t, NAMES, pos, vel=setpoint.vel)


def assert_continuous(flown: list[SwarmSetpoint]) -> None:
    """Neither position nor velocity jumps by more than acc_max, or snapping onto the reference, explains."""
    pos, vel = np.array([tick.pos for tick in flown]), np.array([tick.vel for tick in flown])
    assert np.isfinite(pos).all()
    ends = pos[:-1] + 0.5 * TICK * (vel[1:] + vel[:-1])
    most = np.sqrt(3.0) * PARAMS.acc_max  # of every axis, where jerk is bounded
    assert np.abs(pos[1:] - ends).max() < 0.5 * most * TICK**2 + 1e-4 + 5e-3 * TICK  # SNAP_*
    assert np.linalg.norm(np.diff(vel, axis=0), axis=-1).max() < most * TICK + 5e-3


@JERKS
@pytest.mark.parametrize(
    ("name", "ticks"),
    [("pos", 1), ("vel", 1), ("acc", 1), ("yaw", 1), ("yaw_rate", 1), ("pos", 200), ("yaw", 200)],
)
def test_a_vehicle_without_finite_setpoints_brakes_and_goes_on_with_the_next_one(
    jerk_max: float, name: str, ticks: int
) -> None:
    replanner, flown = SafeReplanner(replace(PARAMS, jerk_max=jerk_max)), []
    end = 1400 if ticks == 200 else 400
    for k in range(end):
        bad = 100 <= k < 100 + ticks
        given = without(apart(k), name) if bad else apart(k)
        flown.append(replanner.update(given, None))
        assert (flown[-1].status[0] == BROKEN) == bad
        assert flown[-1].status[1] == NOMINAL
        assert flown[-1].yaw.tolist() == [0.3, -0.4]
        assert flown[-1].yaw_rate.tolist() == [0.0, 0.0]
        np.testing.assert_array_equal(flown[-1].pos[1], apart(k).pos[1])
    assert_continuous(flown)
    if ticks == 200:  # it rests after SPEED / acc_max, and the ramps of a bounded jerk
        np.testing.assert_allclose(flown[299].vel[0], 0.0, atol=0.02)
        assert 0.2 < flown[299].pos[0, 1] - flown[99].pos[0, 1] < 0.6
    np.testing.assert_array_equal(flown[-1].pos, apart(end - 1).pos)


def test_a_hover_keeps_the_yaw_where_that_is_not_finite_either() -> None:
    replanner = SafeReplanner(PARAMS)
    replanner.update(apart(0), None)
    answer = replanner.update(without(without(apart(1), "pos"), "yaw"), None)
    assert answer.yaw.tolist() == [0.3, -0.4]
    turning = replace(apart(2), yaw=np.array([0.5, 0.6]))
    assert replanner.update(without(turning, "pos"), None).yaw.tolist() == [0.5, 0.6]
    spinning = without(without(apart(3), "pos"), "yaw_rate")
    assert replanner.update(spinning, None).yaw_rate.tolist() == [0.0, 0.0]


@JERKS
def test_a_pair_is_kept_apart_while_one_has_no_finite_setpoint(jerk_max: float) -> None:
    """cf2 hovers in the way of cf1, whose setpoints are NaN for 1 s; both are seen where they are sent."""
    replanner = SafeReplanner(replace(PARAMS, jerk_max=jerk_max))
    last, least, aside = None, np.inf, 0.0
    for k in range(600):
        given = along(k, 0.05)
        pos, vel = given.pos.copy(), given.vel.copy()
        pos[1], vel[1] = [0.05, 3.0, 1.0], 0.0
        given = replace(given, pos=pos, vel=vel)
        given = without(given, "pos") if 150 <= k < 250 else given
        last = replanner.update(given, None if last is None else seen(given, last.pos))
        gap = last.pos[0] - last.pos[1]
        least = min(least, max(np.hypot(gap[0], gap[1]) - PARAMS.eps, abs(gap[2]) - PARAMS.d))
        aside = max(aside, abs(last.pos[1, 0] - 0.05))
        assert last.status[1] != BROKEN
    assert least > 0.0
    assert aside > 0.1


def test_one_that_begins_without_a_finite_setpoint_is_external_until_it_has_one() -> None:
    replanner, there = SafeReplanner(PARAMS), np.array([[0.5, 0.0, 1.0], [0.0, 0.0, 1.0]])
    still = np.zeros((2, 3))
    for k in range(100):
        hover = replace(apart(k), pos=there.copy(), vel=still)
        given = without(hover, "pos")
        answer = replanner.update(given, seen(hover, there))
        assert answer.names == NAMES
        assert np.isnan(answer.pos[0]).all()
        assert answer.status[0] == BROKEN
        assert answer.status[1] != BROKEN
    assert replanner.update(given, None) is answer
    begun = replanner.update(replace(apart(100), pos=there, vel=still), None)
    np.testing.assert_array_equal(begun.pos[0], there[0])
    assert begun.status[0] != BROKEN


@pytest.mark.parametrize("state", [True, False])
def test_nobody_has_a_finite_setpoint(*, state: bool) -> None:
    replanner = SafeReplanner(PARAMS)
    for k in range(3):
        given = without(without(apart(k), "pos", 0), "acc", 1)
        answer = replanner.update(given, seen(given, apart(k).pos) if state else None)
        np.testing.assert_array_equal(answer.pos, given.pos)
        assert answer.status.tolist() == [BROKEN, BROKEN]
    assert replanner.update(apart(3), None).status.tolist() == [NOMINAL, NOMINAL]


def test_a_motion_that_overflowed_is_dropped_and_its_vehicle_a_new_one() -> None:
    motion = at_reference(apart(0))
    motion.rows.acc[0, 1] = np.inf
    assert not moves_finitely(motion)
    some = flyable_inputs(apart(1), motion, None)
    assert some.setpoint.names == NAMES
    assert some.committed is not None
    assert some.committed.names == ("cf2",)
    both = propagate(some.committed, some.setpoint, PARAMS)
    np.testing.assert_array_equal(both.rows.pos[0], apart(1).pos[0])
    assert moves_finitely(both)
