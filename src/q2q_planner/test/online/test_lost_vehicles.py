"""A vehicle that is measured again, or far from its motion, is reset to where it is, and is led back."""

from dataclasses import replace

import numpy as np
import pytest
from resting_signals import resting_setpoint, resting_state

from q2q_model.signals.some_vehicles import of_vehicles
from q2q_model.signals.values import Array, SetpointStatus, SwarmSetpoint, SwarmState, TrackStatus
from q2q_planner.online.replanner import LONGEST_GAP
from q2q_planner.online.safe.lost_vehicles import COAST_S, FRESH_S, LEFT_BEHIND
from q2q_planner.online.safe.motion.safe_replanner_params import SafeReplannerParams
from q2q_planner.online.safe.safe_replanner import SafeReplanner

TICK = 0.01
PARAMS = SafeReplannerParams()
SENT = np.array([[0.0, 0.0, 1.5], [4.0, 0.0, 1.0]])
"""Two vehicles hover, out of each other's reach."""
OFF = np.array([-1.0, 0.5, -0.4])
"""By how much the first is off when it is measured again [m]."""
ON = np.zeros(3)


def setpoint_at(t: float) -> SwarmSetpoint:
    return resting_setpoint(t, ("cf1", "cf2"), SENT)


def state_at(t: float, age: float, off: Array = ON, vel: Array = ON) -> SwarmState:
    """Return the state with the first vehicle off its setpoint, measured `age` ago."""
    pos, speed = SENT + np.array([off, ON]), np.array([vel, ON])
    ages = np.array([age, 0.0])
    return resting_state(t, ("cf1", "cf2"), pos, vel=speed, age=ages)


def flown(unseen_s: float, params: SafeReplannerParams, vel: Array = ON) -> list[SwarmSetpoint]:
    """Return 600 ticks from that on in which the first vehicle is measured again, and then follows."""
    replanner, begin = SafeReplanner(params), round(unseen_s / TICK) + 1
    ticks: list[SwarmSetpoint] = []
    for k in range(begin):
        replanner.update(setpoint_at(k * TICK), state_at(k * TICK, k * TICK))
    for k in range(begin, begin + 600):
        off, speed = (ticks[-1].pos[0] - SENT[0], ON) if ticks else (OFF, vel)
        ticks.append(replanner.update(setpoint_at(k * TICK), state_at(k * TICK, 0.0, off, speed)))
    return ticks


@pytest.mark.parametrize("jerk", [0.0, 20.0])
def test_it_starts_where_it_is_and_is_back_within_the_bounds_of_acceleration(jerk: float) -> None:
    params = replace(PARAMS, jerk_max=jerk)
    back = flown(COAST_S + 0.2, params)
    pos = np.array([tick.pos[0] for tick in back]) - SENT[0]
    np.testing.assert_allclose(pos[0], OFF, atol=1e-12)
    acc = np.diff(pos, n=2, axis=0) / TICK**2
    # acc_max bounds each axis where jerk is bounded; the snap onto the reference moves it by up to 0.1 mm
    assert np.abs(acc[:200]).max() < params.acc_max * 1.01
    np.testing.assert_allclose(pos[-1], 0.0, atol=2e-3)
    assert back[0].status[0] == SetpointStatus.SHIFTED
    assert all(tick.status[1] == SetpointStatus.NOMINAL for tick in back)
    np.testing.assert_array_equal([tick.pos[1] for tick in back], np.tile(SENT[1], (600, 1)))


def test_it_starts_with_its_velocity_up_to_the_fastest_that_is_allowed() -> None:
    vel = np.array([3.0, -4.0, 0.0])
    first = flown(COAST_S + 0.2, PARAMS, vel)[0]
    np.testing.assert_allclose(first.vel[0], vel * PARAMS.speed_max / 5.0, atol=1e-12)


@pytest.mark.parametrize("height", [0.0, 0.02, 0.3])
def test_it_sinks_no_faster_than_it_can_stop_above_the_floor(height: float) -> None:
    replanner, off = SafeReplanner(PARAMS), np.array([0.5, 0.0, height - SENT[0, 2]])
    for k in range(60):
        replanner.update(setpoint_at(k * TICK), state_at(k * TICK, k * TICK))
    found = state_at(0.6, 0.0, off, np.array([0.3, 0.0, -1.1]))
    first = replanner.update(setpoint_at(0.6), found)
    stop = height - first.vel[0, 2] ** 2 / (2.0 * PARAMS.acc_max)
    assert first.vel[0, 0] == 0.3
    assert -1.1 <= first.vel[0, 2] <= 0.0
    assert stop >= -1e-12
    assert first.vel[0, 2] == -1.1 or stop == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("lost_s", [COAST_S + 0.2, PARAMS.forget + 0.2])
def test_it_starts_where_it_is_also_if_the_swarm_changes_meanwhile(lost_s: float) -> None:
    """The second vehicle leaves the swarm in the tick before the first is measured again, or in that tick."""
    for early in (0, 1):
        replanner, begin = SafeReplanner(PARAMS), round(lost_s / TICK) + 1
        for k in range(begin - early):
            replanner.update(setpoint_at(k * TICK), state_at(k * TICK, k * TICK))
        for k in range(begin - early, begin + 1):
            state = state_at(k * TICK, 0.0, OFF) if k == begin else state_at(k * TICK, k * TICK)
            first = replanner.update(of_vehicles(setpoint_at(k * TICK), np.array([0])), state)
        np.testing.assert_allclose(first.pos[0] - SENT[0], OFF, atol=1e-12)


def test_one_that_was_flown_all_the_time_is_led_on_and_announced() -> None:
    """A shorter gap is flown by prediction: a vehicle that is off then has broken the promise."""
    first = flown(COAST_S - 0.1, PARAMS)[0]
    np.testing.assert_array_equal(first.pos, SENT)
    assert first.status.tolist() == [SetpointStatus.PROMISE_BROKEN, SetpointStatus.NOMINAL]


def test_one_that_was_never_measured_begins_on_its_reference() -> None:
    replanner = SafeReplanner(PARAMS)
    for k in range(60):
        replanner.update(setpoint_at(k * TICK), state_at(k * TICK, np.inf))
    np.testing.assert_array_equal(replanner.update(setpoint_at(0.6), state_at(0.6, 0.0, OFF)).pos, SENT)


@pytest.mark.parametrize("aside", [LEFT_BEHIND - 0.03, LEFT_BEHIND + 0.03])
def test_one_that_is_led_back_starts_again_where_it_is_if_it_is_far_from_its_motion(aside: float) -> None:
    replanner, begin = SafeReplanner(PARAMS), 60
    for k in range(begin):
        replanner.update(setpoint_at(k * TICK), state_at(k * TICK, k * TICK))
    first = replanner.update(setpoint_at(0.6), state_at(0.6, 0.0, OFF))
    away = OFF + np.array([0.0, aside, 0.0])
    old = replanner.update(setpoint_at(0.61), state_at(0.61, 2.0 * FRESH_S, away, ON))
    np.testing.assert_allclose(old.pos[0], first.pos[0], atol=1e-3)  # not of this tick
    then = replanner.update(setpoint_at(0.62), state_at(0.62, 0.0, away, ON))
    if aside > LEFT_BEHIND:
        np.testing.assert_allclose(then.pos[0] - SENT[0], away, atol=1e-12)
        assert then.status[0] == SetpointStatus.SHIFTED
    else:
        np.testing.assert_allclose(then.pos[0] - SENT[0], OFF, atol=3e-3)
        assert then.status[0] == SetpointStatus.PROMISE_BROKEN


def crossing_at(t: float) -> SwarmSetpoint:
    """Return references of which the second passes over the first, within its zone, in 6 s."""
    pos = np.array([[0.0, 0.0, 1.5], [0.0, 0.3 * t - 0.9, 2.0]])
    vel = np.array([[0.0, 0.0, 0.0], [0.0, 0.3, 0.0]])
    return resting_setpoint(t, ("cf1", "cf2"), pos, vel=vel)


@pytest.mark.parametrize("jerk", [0.0, 20.0])
@pytest.mark.parametrize("begin", [240, 300, 360])
def test_a_replanner_started_again_in_flight_goes_on_where_the_vehicles_are(begin: int, jerk: float) -> None:
    """Killed while two avoid each other, it would send them to references that are within their zone."""
    params = replace(PARAMS, jerk_max=jerk)
    replanner, flown = SafeReplanner(params), crossing_at(0.0)
    for k in range(600):
        if k == begin:
            assert flown.status.tolist() == [SetpointStatus.SHIFTED] * 2
            replanner = SafeReplanner(params)
        last, sent = flown, crossing_at(k * TICK)
        flown = replanner.update(sent, replace(state_at(sent.t, 0.0), pos=last.pos, vel=last.vel))
        moved = np.linalg.norm(flown.pos - last.pos, axis=1)
        assert moved.max() <= params.speed_max * TICK
        rel_pos = flown.pos[1] - flown.pos[0]
        assert np.hypot(rel_pos[0], rel_pos[1]) > params.eps
        assert not (flown.status == SetpointStatus.PROMISE_BROKEN).any()


@pytest.mark.parametrize("jerk", [0.0, 20.0])
@pytest.mark.parametrize("passed", [LONGEST_GAP + 0.2, -LONGEST_GAP - 0.2])
def test_after_a_gap_it_goes_on_where_the_vehicles_are_as_one_started_again_does(
    passed: float, jerk: float
) -> None:
    """The first waits beside the second, through which its reference has led meanwhile."""
    params = replace(PARAMS, jerk_max=jerk)
    before = crossing_at(3.0)
    waiting = before.pos - np.array([[0.0, 0.0, 0.0], [0.0, 0.6, 0.0]])
    beyond = before.pos + np.array([[0.0, 0.0, 0.0], [0.0, 1.2, 0.0]])
    old, new = SafeReplanner(params), SafeReplanner(params)
    old.update(replace(before, pos=waiting), replace(state_at(3.0, 0.0), pos=waiting))
    for k in range(-10, 3):
        t = 3.0 + passed + k * TICK
        sent, seen = replace(before, t=t, pos=beyond), replace(state_at(t, 0.0), pos=waiting)
        goes_on = old.update(sent, seen)
        if k < 0:  # the gap is not accepted yet
            continue
        anew = new.update(sent, seen)
        np.testing.assert_array_equal(goes_on.pos, anew.pos)
        assert goes_on.status.tolist() == anew.status.tolist()
        np.testing.assert_allclose(goes_on.pos[1], waiting[1], atol=0.01)
        assert goes_on.status[1] == SetpointStatus.SHIFTED


@pytest.mark.parametrize(
    ("enabled", "status", "starts"),
    [(True, TrackStatus.TRACKED, OFF), (False, TrackStatus.TRACKED, ON), (True, TrackStatus.COASTING, ON)],
)
def test_it_starts_where_a_vehicle_is_tracked_and_else_on_the_reference(
    enabled: bool, status: TrackStatus, starts: Array
) -> None:
    """A filter that begins tracks nobody, as its first frame may be an outlier."""
    state = replace(state_at(0.0, 0.0, OFF), status=np.full(2, status, np.uint8))
    first = SafeReplanner(replace(PARAMS, enabled=enabled)).update(setpoint_at(0.0), state)
    np.testing.assert_allclose(first.pos[0], SENT[0] + starts, atol=0.01)


def test_one_on_its_reference_stays_there_however_far_it_is() -> None:
    replanner = SafeReplanner(PARAMS)
    replanner.update(setpoint_at(0.0), state_at(0.0, 0.0))
    far = replanner.update(setpoint_at(0.01), state_at(0.01, 0.0, OFF))
    np.testing.assert_array_equal(far.pos, SENT)
    assert far.status.tolist() == [SetpointStatus.PROMISE_BROKEN, SetpointStatus.NOMINAL]
