"""Vehicles send one prediction in each of their slots, and slots are spread over the period."""

import numpy as np
import pytest
from resting_signals import resting_state

from q2q_control.mpc.neighbours.time_slots import BroadcastSchedule, slot_start
from q2q_model.signals.stamps import SAME_STAMP
from q2q_model.signals.values import Names, SwarmState

TICK = 0.01
NAMES = tuple(f"cf{k}" for k in range(1, 11))


def state(t: float, names: Names = NAMES) -> SwarmState:
    n = len(names)
    zero = np.zeros((n, 3))
    return resting_state(t, names, zero)


def sent(period: float, names: Names, times: list[float]) -> np.ndarray:
    """Return which vehicles send in which tick, (ticks, n)."""
    schedules = [BroadcastSchedule((name,), period) for name in names]
    return np.array([[schedule.take_turn(state(t, names)) for schedule in schedules] for t in times])


@pytest.mark.parametrize("since", [0.0, 1.7e9])
def test_ten_vehicles_at_ten_hertz_send_one_after_the_other(since: float) -> None:
    turns = sent(0.1, NAMES, [since + TICK * k for k in range(61)])
    assert turns[0].all()  # everybody's first
    assert (turns[10:].sum(axis=1) == 1).all()
    assert (turns[10:60].sum(axis=0) == 5).all()


def test_at_the_rate_of_the_ticks_every_vehicle_sends_in_every_tick() -> None:
    assert sent(TICK, NAMES[:3], [TICK * k for k in range(50)]).all()


def test_what_receivers_expect_by_a_tick_has_been_sent_by_then_with_uneven_stamps() -> None:
    times = np.cumsum(np.random.default_rng(1).uniform(0.004, 0.04, 300)).tolist()
    turns = sent(0.1, NAMES[:3], times)
    last = {}
    for t, now in zip(times, turns, strict=True):
        last |= {name: t for name, turn in zip(NAMES, now, strict=False) if turn}
        now_known = state(t, NAMES[:3])
        assert all(slot_start(now_known, row, 0.1) - SAME_STAMP < last[NAMES[row]] for row in range(3))
    assert turns.sum() < 3 * (times[-1] / 0.1 + 2)


def test_a_node_of_two_vehicles_sends_in_the_slots_of_both() -> None:
    both = BroadcastSchedule(NAMES[:2], 0.1)
    turns = [both.take_turn(state(TICK * k, NAMES[:2])) for k in range(21)]
    assert np.flatnonzero(turns).tolist() == [0, 5, 10, 15, 20]


def test_after_a_clock_is_set_back_predictions_are_sent_again() -> None:
    schedule = BroadcastSchedule(("cf1",), 0.1)
    assert [schedule.take_turn(state(t)) for t in (50.0, 50.01, 3.0, 3.01)] == [True, False, True, False]
