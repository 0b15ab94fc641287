"""What the simulator does with commands that come, and with those that do not."""

import tracemalloc

import numpy as np
import pytest
from resting_signals import level_command

from q2q_model.signals.values import SwarmCommand
from q2q_sim.loop.command_gate import CommandGate, unknown_vehicles
from q2q_sim.simulator.flight_clock import FlightClock
from q2q_sim.simulator.resend_timer import ResendTimer


def command(names: tuple[str, ...], thrust: float) -> SwarmCommand:
    n = len(names)
    return level_command(0.0, names, np.full(n, thrust))


def test_one_controller_for_all_completes_a_tick_at_once() -> None:
    gate = CommandGate(("cf1", "cf2"))
    gate.expect(10)
    whole = command(("cf1", "cf2"), 1.0)
    assert gate.offer(10, whole) is whole


def test_one_controller_a_vehicle_completes_a_tick_with_the_last_of_them_in_the_swarms_order() -> None:
    gate = CommandGate(("cf1", "cf2"))
    gate.expect(10)
    assert gate.offer(10, command(("cf2",), 2.0)) is None
    whole = gate.offer(10, command(("cf1",), 1.0))
    assert whole is not None
    assert whole.names == ("cf1", "cf2")
    assert whole.thrust.tolist() == [1.0, 2.0]


def test_a_command_for_another_tick_does_not_count() -> None:
    gate = CommandGate(("cf1",))
    gate.expect(20)
    assert gate.offer(10, command(("cf1",), 1.0)) is None


def test_live_a_late_or_a_fallback_command_counts_and_an_older_one_does_not() -> None:
    gate = CommandGate(("cf1",), exact=False)
    gate.expect(30)
    assert gate.offer(20, command(("cf1",), 1.0)) is not None
    gate.expect(40)
    assert gate.offer(20, command(("cf1",), 1.0)) is None
    assert gate.offer(57, command(("cf1",), 1.0)) is not None


def test_live_commands_stamped_ahead_make_those_of_the_following_ticks_no_older_ones() -> None:
    """As those of a failsafe that went on by the wall clock while the room stood."""
    gate = CommandGate(("cf1",), exact=False)
    gate.expect(10)
    taken = [gate.offer(stamp, command(("cf1",), 1.0)) is not None for stamp in (500, 600, 500)]
    assert taken == [True, True, False]  # within the tick, the newest
    gate.expect(20)
    assert gate.offer(10, command(("cf1",), 1.0)) is None
    assert gate.offer(20, command(("cf1",), 1.0)) is not None


def test_live_commands_are_taken_on_after_the_stamps_of_frames_are_set_back() -> None:
    gate = CommandGate(("cf1",), exact=False)
    for stamp, taken in ((500, True), (10, False), (20, True), (30, True)):
        gate.expect(stamp)
        assert (gate.offer(stamp, command(("cf1",), 1.0)) is not None) is taken


def test_live_a_controller_that_is_silent_keeps_back_no_other_vehicles_command() -> None:
    gate = CommandGate(("cf1", "cf2", "cf3"), exact=False)
    gate.expect(10)
    assert gate.arrived() is None
    for name in ("cf3", "cf1"):
        assert gate.offer(10, command((name,), 3.0)) is None
    some = gate.arrived()
    assert some is not None
    assert some.names == ("cf1", "cf3")
    gate.expect(20)
    assert gate.offer(10, command(("cf2",), 2.0)) is None  # late, and newer than its last
    assert gate.offer(20, command(("cf1",), 4.0)) is None
    whole = gate.offer(20, command(("cf3",), 5.0))
    assert whole is not None
    assert whole.thrust.tolist() == [4.0, 2.0, 5.0]


def test_a_command_for_a_vehicle_that_does_not_exist_is_refused_by_name() -> None:
    gate = CommandGate(("cf1", "cf2"))
    with pytest.raises(ValueError, match="unknown vehicle cf9; the vehicles are cf1, cf2"):
        gate.offer(0, command(("cf9",), 1.0))


@pytest.mark.parametrize("exact", [True, False])
def test_of_a_command_for_a_vehicle_too_many_the_others_are_flown(exact: bool) -> None:
    gate = CommandGate(("cf1", "cf2"), exact=exact)
    gate.expect(10)
    flown = gate.offer(10, command(("cf9", "cf2", "cf1"), 3.0))
    assert flown is not None
    assert (flown.names, flown.thrust.tolist()) == (("cf1", "cf2"), [3.0, 3.0])
    assert gate.missing() == ()
    said = "command for unknown vehicle cf9; the vehicles are cf1, cf2"
    assert unknown_vehicles(("cf1", "cf2", "cf9"), ("cf1", "cf2")) == said
    assert unknown_vehicles(("cf1",), ("cf1", "cf2")) == ""


def test_a_lost_tick_is_asked_for_again_and_then_given_up_and_the_next_ones_sooner() -> None:
    resend = ResendTimer(period_s=0.25, timeout_s=10.0)
    resend.begin(0.0)
    assert not resend.poll_resend(0.2)
    assert resend.poll_resend(0.3)
    assert not resend.poll_resend(0.4)
    assert not resend.poll_expiry(9.9)
    assert resend.poll_expiry(10.0)
    resend.begin(10.0)
    assert resend.poll_expiry(10.3)
    resend.answered()
    resend.begin(11.0)
    assert not resend.poll_expiry(20.0)


def test_the_flight_clock_reports_percentiles_of_the_ticks_that_were_answered() -> None:
    clock = FlightClock()
    assert clock.recent() == {}
    clock.start(100.0)
    for tick in range(101):
        clock.frame_out(tick, 200.0 + tick)
        clock.command_in(tick, 200.0 + tick + tick * 1e-3)
    clock.missed()
    timing = clock.timing(now=105.0, flown=50.0)
    assert timing.real_time_factor == pytest.approx(10.0)
    assert timing.latency_p50_ms == pytest.approx(50.0)
    assert timing.latency_p99_ms == pytest.approx(99.0)
    assert (timing.ticks, timing.missed_ticks) == (101, 1)


def test_the_line_about_a_flights_time_has_plain_numbers() -> None:
    clock = FlightClock()
    clock.start(0.0)
    clock.frame_out(0, 0.0)
    clock.command_in(0, 0.002)
    assert str(clock.timing(0.5, 1.0)) == (
        "FlightTiming(ticks=1, missed_ticks=0, real_time_factor=2.0, latency_p50_ms=2.0, latency_p99_ms=2.0)"
    )


def test_the_clock_of_a_flight_holds_no_more_than_eight_bytes_a_tick() -> None:
    """And what an array keeps in reserve: an eighth."""
    clock, ticks = FlightClock(), 20_000
    tracemalloc.start()
    try:
        for tick in range(ticks):
            clock.frame_out(tick, 0.01 * tick)
            clock.command_in(tick, 0.01 * tick + 1e-3)
        held, _ = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert held < 10 * ticks
    assert clock.timing(1.0, 1.0).latency_p99_ms == pytest.approx(1.0)
