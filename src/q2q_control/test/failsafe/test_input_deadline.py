"""Vehicles hold, level, land and stop when no tick comes by its deadline."""

import pytest
from guarded_flights import (
    CUT,
    DEGRADED,
    HOLD,
    LAND,
    LEVEL,
    PARAMS,
    SATURATED,
    TICK,
    guarded,
    setpoint_at,
    state_at,
)

from q2q_control.failsafe.guard import Guard
from q2q_control.failsafe.input_deadline import InputDeadline


def answered_ticks(ticks: int) -> tuple[Guard, InputDeadline]:
    guard = guarded()
    deadline = InputDeadline(guard, PARAMS)
    for k in range(ticks):
        guard.update(state_at(k * TICK), setpoint_at(k * TICK), None)
        deadline.answered(setpoint_at(k * TICK), now=100.0 + k * TICK)
    return guard, deadline


def test_a_reference_that_stays_away_leaves_a_vehicle_hovering_where_it_was_sent() -> None:
    _, deadline = answered_ticks(10)
    assert deadline.due(state_at(0.12), now=100.0 + 0.115) is None  # 25 ms late: merely late
    command = deadline.due(state_at(0.12), now=100.0 + 0.125)
    assert command is not None
    assert command.t == 0.12
    assert command.status.tolist() == [DEGRADED] * 2
    assert command.pitch[0] == pytest.approx(
        4.0 * 0.1 / 9.81, rel=0.02
    )  # k_p_xy x error over g: still tracking
    again = deadline.due(state_at(0.13), now=100.0 + 0.135)
    assert again is not None
    assert again.t == 0.13  # the next state is taken at once


def test_a_hover_in_place_of_a_reference_is_degraded_even_at_the_limits() -> None:
    guard = guarded()
    deadline = InputDeadline(guard, PARAMS)
    for t in (0.0, 0.01):
        guard.update(state_at(t), setpoint_at(t, x=50.0), None)
    deadline.answered(setpoint_at(0.01, x=50.0), now=0.0)
    command = deadline.due(state_at(0.02), now=0.03)  # just then
    assert command is not None
    assert command.status.tolist() == [DEGRADED] * 2
    assert guard.update(state_at(0.02), setpoint_at(0.02, x=50.0), None).status[0] == SATURATED


def test_without_a_newer_state_a_missing_tick_is_held_after_hold_s() -> None:
    _, deadline = answered_ticks(10)
    assert deadline.due(state_at(0.09), now=100.0 + 0.119) is None
    held = deadline.due(state_at(0.09), now=100.0 + 0.121)
    assert held is not None
    assert held.status.tolist() == [HOLD] * 2
    assert held.t == pytest.approx(0.121)


def test_after_an_emergency_nothing_is_due_while_ticks_come_and_a_cut_without_them() -> None:
    guard, deadline = answered_ticks(10)
    assert guard.cut_all() is not None
    for late in (0.0, 0.01, 0.029):
        assert deadline.due(state_at(0.09), now=100.0 + 0.09 + late) is None
    command = deadline.due(state_at(0.09), now=100.0 + 0.121)
    assert command is not None
    assert command.status.tolist() == [CUT] * 2


def test_a_real_tick_ends_the_hovering() -> None:
    guard, deadline = answered_ticks(10)
    deadline.due(state_at(0.12), now=100.125)
    guard.update(state_at(0.13), setpoint_at(0.13), None)
    deadline.answered(setpoint_at(0.13), now=100.131)
    assert deadline.due(state_at(0.14), now=100.141) is None


def test_frames_that_repeat_are_no_news() -> None:
    _, deadline = answered_ticks(10)
    statuses = []
    for k in range(10, 130):  # the last tick is answered again and again
        now = 100.0 + k * TICK
        deadline.answered(setpoint_at(0.09), now)
        command = deadline.due(state_at(0.09), now)
        statuses.append(None if command is None else int(command.status[0]))
    assert statuses[0] is None
    assert statuses[4] == HOLD
    assert statuses[50] == LEVEL
    assert statuses[-1] == LAND


@pytest.mark.parametrize("off", [-10.0, 10.0])
def test_a_state_whose_stamp_is_far_off_is_no_news(off: float) -> None:
    guard, deadline = answered_ticks(10)
    statuses = []
    for k in range(10, 130):  # it comes again and again, and nothing else
        now = 100.0 + k * TICK
        guard.update(state_at(0.1 + off), setpoint_at(0.1 + off), None)
        deadline.answered(setpoint_at(0.1 + off), now)
        command = deadline.due(state_at(0.1 + off), now)
        statuses.append(None if command is None else int(command.status[0]))
    assert (statuses[0], statuses[4], statuses[50], statuses[-1]) == (None, HOLD, LEVEL, LAND)


def test_an_old_tick_is_no_news_and_that_of_a_clock_set_back_is() -> None:
    guard, deadline = answered_ticks(10)
    guard.update(state_at(0.07), setpoint_at(0.07), None)
    deadline.answered(setpoint_at(0.07), now=100.10)
    held = deadline.due(state_at(0.07), now=100.09 + PARAMS.hold_after_s + 0.001)
    assert held is not None
    assert held.status.tolist() == [HOLD] * 2
    now = 100.2
    for k in range(20):  # longer than old stamps must rise to be the new time
        guard.update(state_at(-0.5 + k * TICK), setpoint_at(-0.5 + k * TICK), None)
        deadline.answered(setpoint_at(-0.5 + k * TICK), now=now + k * TICK)
    assert guard.newest == pytest.approx(-0.31)
    assert deadline.due(state_at(-0.31), now=now + 0.20) is None
