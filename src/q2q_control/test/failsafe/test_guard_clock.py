"""The guard on ticks that are repeated, older, or of a clock that was set back."""

from dataclasses import replace

import numpy as np
import pytest
from guarded_flights import (
    CUT,
    HOLD,
    HOVER,
    LAND,
    LEVEL,
    OK,
    PARAMS,
    TICK,
    fly,
    guarded,
    pid,
    setpoint_at,
    state_at,
)

from q2q_control.failsafe.guard import Guard
from q2q_control.failsafe.stamp_delay import StampDelayMonitor


def test_an_older_tick_gets_the_last_answer() -> None:
    guard = guarded()
    last = fly(guard, 0, 300)[-1]
    for t in (2.95, 2.5, 2.0):  # out of order: still the same clock
        again = guard.update(state_at(t), setpoint_at(t), None)
        assert again.t == t
        assert again.pitch.tolist() == last.pitch.tolist()
        assert again.status.tolist() == [HOLD, HOLD]


@pytest.mark.parametrize("back", [0.2, 1.0])
def test_a_clock_set_back_lets_ages_go_on_and_leaves_who_is_cut_on_the_floor(back: float) -> None:
    guard = guarded()
    for k in range(520):
        t = k * TICK
        output = guard.update(state_at(t, (t, 0.0), coast=10.0), setpoint_at(t), None)
    assert output.status.tolist() == [CUT, OK]
    begin = t - back
    for k in range(11):
        now = begin + k * TICK
        output = guard.update(state_at(now, (t, 0.0), coast=10.0), setpoint_at(now), None)
        assert output.t == now
        assert output.status.tolist() == [CUT, HOLD if k < 10 else OK]


def test_a_clock_set_back_does_not_make_young_who_was_not_seen() -> None:
    guard = guarded()
    for k in range(96):
        t = k * TICK
        guard.update(state_at(t, (t, 0.0), coast=0.35), setpoint_at(t), None)
    begin = 0.3  # unseen for 0.95 s, by whatever clock
    statuses = []
    for k in range(18):
        t = begin + k * TICK
        output = guard.update(state_at(t, (np.inf, 0.0), coast=0.35), setpoint_at(t), None)
        statuses.append(output.status[0])
    assert LAND not in statuses[:10]
    assert statuses[10:] == [LAND] * 8  # 1.05 s and more: the 0.1 s before the new time is accepted count


def test_a_clock_set_back_does_not_age_who_was_just_seen() -> None:
    guard = guarded()
    for k in range(300):
        t = k * TICK
        guard.update(state_at(t, (max(t - 2.8, 0.0), 0.0), coast=0.35), setpoint_at(t), None)
    begin, statuses = 2.4, []  # unseen for 0.19 s, by whatever clock
    for k in range(100):
        t = begin + k * TICK
        output = guard.update(state_at(t, (np.inf, 0.0), coast=0.35), setpoint_at(t), None)
        statuses.append(output.status[0])
    assert statuses.index(LAND) == pytest.approx((PARAMS.land_after_s - 0.19) / TICK, abs=1)


def test_a_flight_that_begins_again_is_another_one() -> None:
    guard = guarded()
    for k in range(520):
        t = k * TICK
        guard.update(state_at(t, (t, 0.0), coast=10.0), setpoint_at(t), None)
    anew = [guard.update(state_at(t), setpoint_at(t), None) for t in (4.0 + k * TICK for k in range(11))]
    assert [one.status.tolist() for one in anew] == [[CUT, HOLD]] * 10 + [[OK, OK]]
    assert anew[-1].t == guard.newest


@pytest.mark.parametrize("frames", [1, 10])
@pytest.mark.parametrize("off", [-1e9, -6.0, -3.0, 3.0, 6.0, 1e9])
def test_few_stamps_far_off_are_held_and_leave_no_trace(off: float, frames: int) -> None:
    guard, twin = guarded(), guarded()
    before = fly(guard, 0, 50)[-1]
    fly(twin, 0, 50)
    for t in (off + (50 + k) * TICK for k in range(frames)):
        wrong = guard.update(state_at(t), setpoint_at(t), None)
        assert (wrong.t, wrong.status.tolist()) == (t, [HOLD, HOLD])
        np.testing.assert_array_equal(wrong.thrust, before.thrust)
    for output, expected in zip(fly(guard, 61, 70), fly(twin, 61, 70), strict=True):
        assert output.status.tolist() == [OK, OK]
        np.testing.assert_array_equal(output.pitch, expected.pitch)


def test_live_a_clock_set_ahead_cuts_nobody_and_who_is_not_measured_lands_by_the_wall_clock() -> None:
    stamp_delay, now = StampDelayMonitor(), [0.0]
    guard = Guard(pid(), PARAMS, HOVER, lateness=lambda t: stamp_delay.lateness(t, now[0]))
    statuses = []
    for k in range(300):
        now[0] = t = k * TICK
        ahead = t + 10.0 * (k >= 100)
        ages = t - 0.8 if k > 80 else 0.0, 0.0
        output = guard.update(state_at(ahead, ages), setpoint_at(ahead), None)
        statuses.append(output.status.tolist())
    assert {status for _, status in statuses[100:110]} == {HOLD}
    assert {status for _, status in statuses[110:]} == {OK}
    assert [first for first, _ in statuses].index(LAND) == pytest.approx(180, abs=1)
    assert CUT not in statuses[-1]


def test_in_lockstep_stamps_are_the_only_clock() -> None:
    guard = guarded()
    fly(guard, 0, 50)
    statuses = [
        guard.update(state_at(t, (t - 0.49, 0.0), coast=10.0), setpoint_at(t), None).status.tolist()
        for t in (6.0 + k * TICK for k in range(11))
    ]
    assert statuses == [[HOLD, HOLD]] * 10 + [[CUT, OK]]


def test_at_a_low_rate_a_gap_is_accepted_with_its_second_stamp() -> None:
    guard = guarded()
    fly(guard, 0, 50)
    ticks = [guard.update(state_at(t, (t - 0.49, 0.0)), setpoint_at(t), None) for t in (2.0, 3.5, 5.0, 6.5)]
    assert [one.status.tolist() for one in ticks] == [[HOLD, HOLD], [LAND, OK], [LAND, HOLD], [CUT, OK]]


def test_a_repeated_tick_is_no_older_one() -> None:
    guard = guarded()
    first = fly(guard, 0, 5)[-1]
    again = guard.update(state_at(0.04), setpoint_at(0.04), None)
    assert again.status.tolist() == [OK, OK]
    np.testing.assert_array_equal(again.pitch, first.pitch)


def test_a_tick_older_by_just_what_a_restart_takes_is_of_the_same_flight() -> None:
    guard = guarded()
    guard.update(state_at(2.0), setpoint_at(2.0), None)
    assert guard.update(state_at(1.0), setpoint_at(1.0), None).status.tolist() == [HOLD, HOLD]
    assert guard.newest == 2.0


def test_a_tick_that_comes_for_longer_than_a_hold_is_that_of_a_clock_that_stands() -> None:
    guard = guarded()
    last = fly(guard, 0, 50)[-1]
    moving = replace(state_at(last.t), vel=np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]))
    again = [guard.update(moving, setpoint_at(last.t), None) for _ in range(500)]
    held = round(PARAMS.level_after_s / TICK)
    for one in again[:held]:  # published again: the same answer
        assert one.status.tolist() == [OK, OK]
        np.testing.assert_array_equal(one.pitch, last.pitch)
    assert {one.t for one in again} == {last.t}
    assert all(one.status.tolist() == [LEVEL, LEVEL] for one in again[held:]), "nobody lands or is cut"
    on = fly(guard, 50, 51)[0]
    assert on.status.tolist() == [OK, OK]


def test_stamps_that_go_back_after_a_clock_that_stood_are_not_held_for_longer() -> None:
    guard = guarded()
    last = fly(guard, 0, 50)[-1]
    for _ in range(15):
        guard.update(state_at(last.t), setpoint_at(last.t), None)
    old = [last.t - 0.3 + k * TICK for k in range(10)]
    statuses = [guard.update(state_at(t), setpoint_at(t), None).status.tolist() for t in old]
    assert statuses == [[LEVEL, LEVEL]] * 10
