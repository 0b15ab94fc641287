"""What nodes report of a flight: ticks that are counts, and a flight that stands still."""

import pytest

from q2q_sim.processes.flight_progress import STILL_S, FlightProgress


def test_ticks_that_are_no_count_and_a_clock_that_is_none_leave_the_last_ticks() -> None:
    flight = FlightProgress(now=0.0)
    flight.take_diagnostics("/other/simulator", {"ticks": "12"})
    for ticks in ("12.5", "", "many", "-1"):
        flight.take_diagnostics("/other/simulator", {"ticks": ticks})
    flight.take_diagnostics("/bag_play", {})
    flight.take_diagnostics("/pid", {"ticks": "99"})
    flight.take_clock(1, 2**32 - 1)
    assert flight.ticks == 12
    flight.take_clock(1, 20_000_000)
    assert flight.ticks == 102


def test_a_flight_without_a_tick_for_too_long_has_failed() -> None:
    flight = FlightProgress(now=0.0)
    flight.start(100.0)
    flight.check(100.0 + STILL_S)
    flight.take_clock(0, 10_000_000)
    flight.check(101.0 + STILL_S)
    flight.check(101.0 + 2.0 * STILL_S)
    with pytest.raises(TimeoutError, match=r"no tick for 60 s after tick 1; see the nodes' logs"):
        flight.check(101.1 + 2.0 * STILL_S)
