"""The delay of stamps over the recent minimum adds to the age of a state."""

import numpy as np
import pytest
from guarded_flights import DEGRADED, HOVER, OK, PARAMS, TICK, pid, setpoint_at, state_at
from numpy.typing import NDArray

from q2q_control.failsafe.guard import Guard
from q2q_control.failsafe.stamp_delay import MOST_S, WINDOW_S, StampDelayMonitor


def test_the_largest_lateness_that_is_reported_lands_nobody() -> None:
    assert PARAMS.land_after_s > MOST_S


def test_a_stream_that_is_suddenly_late_shows_by_how_much() -> None:
    clock = StampDelayMonitor()
    for k in range(100):
        assert clock.lateness(k * TICK, 5000.0 + k * TICK + 0.02) == pytest.approx(0.0, abs=1e-9)
    assert clock.lateness(1.0, 5001.0 + 0.02 + 0.2) == pytest.approx(0.2, abs=1e-9)
    assert clock.lateness(1.01, 5001.01 + 0.02 + 3.0) == MOST_S


def test_what_was_usual_is_forgotten_after_two_windows() -> None:
    clock = StampDelayMonitor()
    clock.lateness(0.0, 100.0)
    late = [clock.lateness(k * TICK, 100.0 + k * TICK + 0.1) for k in range(1, 450)]
    assert late[0] == pytest.approx(0.1, abs=1e-9)
    assert late[300] == pytest.approx(0.1, abs=1e-9)  # windows are of 2 s
    assert late[-1] == pytest.approx(0.0, abs=1e-9)


def test_a_window_ends_after_its_length_not_with_it() -> None:
    clock = StampDelayMonitor()
    clock.lateness(0.0, 0.0)
    late = [clock.lateness(now - 0.1, now) for now in (WINDOW_S, 2.5, 4.2)]
    assert late == pytest.approx([0.1, 0.1, 0.1], abs=1e-9)


def test_a_step_ahead_is_a_negative_lateness_once_and_one_back_begins_anew() -> None:
    clock = StampDelayMonitor()
    ticks = [(0.0, 5.0), (0.01, 5.01), (10.02, 5.02), (10.03, 5.03), (1.04, 5.04), (10.05, 5.05)]
    late = [clock.lateness(stamp, now) for stamp, now in ticks]
    assert late == pytest.approx([0.0, 0.0, -10.0, 0.0, 0.0, -9.0], abs=1e-9)


def test_a_clock_that_runs_slower_lands_nobody_by_itself() -> None:
    assert PARAMS.land_after_s > MOST_S


def test_lateness_adds_to_the_age() -> None:
    lateness_s: NDArray[np.float64] = np.zeros(1)
    guard = Guard(pid(), PARAMS, HOVER, lateness=lambda _: float(lateness_s[0]))
    assert guard.update(state_at(0.0), setpoint_at(0.0), None).status.tolist() == [OK, OK]
    lateness_s[0] = 0.06
    assert guard.update(state_at(0.01), setpoint_at(0.01), None).status.tolist() == [
        OK,
        OK,
    ]  # known since 0.0
    output = [guard.update(state_at(k * TICK), setpoint_at(k * TICK), None).status[0] for k in range(2, 12)]
    assert DEGRADED in output
