"""Flight of a room: which signals leave after the start, after commands and after timer events."""

from dataclasses import replace

import numpy as np
import pytest
from resting_signals import level_command

from q2q_model.signals.cdr.cdr_writer import encode
from q2q_model.signals.stamps import TICK_NS
from q2q_model.signals.values import MocapFrame, SwarmCommand
from q2q_sim.loop.room import Room
from q2q_sim.simulator.flight_output import NOTHING, Output
from q2q_sim.simulator.room_flight import FIRST_TIMEOUT_S, RoomFlight
from q2q_sim.simulator.simulator_params import SimulatorParams, chosen_scenario

PARAMS = SimulatorParams(resend_period_s=1.0, command_timeout_s=3.0)
SCENARIO = chosen_scenario(PARAMS)


class Wall:
    """Wall clock that tests advance."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        """Return the time [s]."""
        return self.now


def flight(wall: Wall, params: SimulatorParams = PARAMS, duration: float = 1.0) -> RoomFlight:
    return RoomFlight(Room(SCENARIO, seed=1), params, duration, wall)


def command(thrust: float) -> SwarmCommand:
    n = len(SCENARIO.names)
    return level_command(0.0, SCENARIO.names, np.full(n, thrust))


def topics(output: Output) -> list[str]:
    return [signal.topic for signal in output.signals]


def frame(output: Output) -> MocapFrame:
    assert isinstance(output.signals[0].signal, MocapFrame)
    return output.signals[0].signal


def test_in_lockstep_each_command_advances_the_room_by_one_tick() -> None:
    flown, room = flight(Wall()), Room(SCENARIO, seed=1)
    output = flown.start()
    for tick in range(5):
        assert topics(output) == ["mocap", "truth", "truth_interference", "imu"]
        assert output.clock_ns == output.signals[1].stamp_ns == tick * TICK_NS
        np.testing.assert_array_equal(frame(output).pos, room.capture().frame.pos)
        room.advance(command(0.3))
        output = flown.receive(encode(command(0.3), tick * TICK_NS))
    assert flown.health.ticks == 5


def test_a_flight_starts_once_and_ends_with_its_timing_after_its_duration() -> None:
    wall = Wall()
    flown = flight(wall, duration=0.02)
    assert flown.receive(encode(command(0.3), 0)) == NOTHING
    flown.start()
    assert flown.start() == NOTHING
    flown.receive(encode(command(0.3), 0))
    wall.now = 0.01
    output = flown.receive(encode(command(0.3), TICK_NS))
    assert output.signals == ()
    assert output.timing is not None
    assert (output.timing.ticks, output.timing.real_time_factor) == (2, pytest.approx(2.0))
    assert not flown.is_flying
    assert flown.on_timer() == NOTHING
    assert "the flight is over" in flown.refusal
    assert flown.start() == flown.on_timer() == NOTHING
    assert flown.health.ticks == 2


@pytest.mark.parametrize(("delay", "missed"), [(0.005, 0), (0.012, 50), (0.095, 50)])
def test_live_a_command_counts_for_its_own_frame_however_late_it_is(delay: float, missed: int) -> None:
    wall = Wall()
    flown = flight(wall, replace(PARAMS, pace="live"), duration=0.5)
    flown.start()
    due, output = [], NOTHING
    for tick in range(51):
        for t, stamp in [one for one in due if one[0] < 0.01 * tick]:
            wall.now = t
            flown.receive(encode(command(0.3), stamp))
            due.remove((t, stamp))
        wall.now = 0.01 * tick
        output = flown.on_timer()
        due += [(wall.now + delay, one.stamp_ns) for one in output.signals[:1]]
    assert output.timing is not None
    assert output.timing.missed_ticks == missed
    assert output.timing.latency_p50_ms == pytest.approx(1e3 * delay)
    assert output.timing.latency_p99_ms == pytest.approx(1e3 * delay)


def test_live_the_newest_command_is_flown() -> None:
    wall = Wall()
    flown, room = flight(wall, replace(PARAMS, pace="live")), Room(SCENARIO, seed=1)
    flown.start()
    flown.on_timer()
    room.capture()
    room.advance(None)
    flown.on_timer()
    for stamp, thrust in ((0, 0.1), (TICK_NS, 0.4), (0, 0.2)):
        flown.receive(encode(command(thrust), stamp))
    room.capture()
    room.advance(command(0.4))
    for _ in range(3):
        output = flown.on_timer()
        np.testing.assert_array_equal(frame(output).pos, room.capture().frame.pos)
        room.advance(None)


def test_live_after_commands_stamped_ahead_those_of_the_next_frames_are_flown() -> None:
    """A simulator that was stopped for 1 s finds the commands of the failsafe meanwhile."""
    flown, room = flight(Wall(), replace(PARAMS, pace="live")), Room(SCENARIO, seed=1)
    flown.start()
    flown.on_timer()
    for ahead in range(3, 101):
        flown.receive(encode(command(0.2), ahead * TICK_NS))
    for tick in range(1, 4):
        room.capture()
        room.advance(command(0.2 if tick == 1 else 0.4))
        output = flown.on_timer()
        np.testing.assert_array_equal(frame(output).pos, room.capture().frame.pos)
        flown.receive(encode(command(0.4), tick * TICK_NS))
    assert flown.health.missed == 1  # no command ahead answers its tick


def test_in_lockstep_an_unanswered_frame_is_published_again_and_the_tick_is_missed_at_last() -> None:
    wall = Wall()
    flown = flight(wall)
    first = flown.start()
    wall.now = 0.5
    assert flown.on_timer() == NOTHING
    wall.now = 1.5
    again = flown.on_timer()
    assert again.signals == first.signals[:1]
    assert again.clock_ns is None
    wall.now = 3.0
    assert flown.on_timer().clock_ns == TICK_NS
    assert flown.health.missed == 1


def test_live_the_timer_advances_the_room_with_the_command_that_arrived() -> None:
    wall = Wall()
    flown = flight(wall, replace(PARAMS, pace="live"), duration=0.03)
    assert flown.on_timer() == flown.start() == flown.start() == NOTHING
    wall.now = 0.007
    assert flown.on_timer().clock_ns == 0  # with a whole period for the first command
    assert flown.receive(encode(command(0.3), 0)) == NOTHING
    assert flown.on_timer().clock_ns == TICK_NS
    assert flown.health.missed == 0
    assert flown.on_timer().clock_ns == 2 * TICK_NS
    assert flown.health.missed == 1
    wall.now = 0.037
    timing = flown.on_timer().timing
    assert timing is not None
    assert timing.real_time_factor == pytest.approx(1.0)  # from the first tick on


def test_live_after_other_nodes_the_first_frame_waits_for_a_command() -> None:
    """DDS may deliver nothing to a new reader for seconds; commands of the flight before count, too."""
    wall = Wall()
    flown = flight(wall, replace(PARAMS, pace="live", starts_after=("pid",)))
    flown.start()
    assert topics(flown.on_timer())[0] == "mocap"
    for now, sent in ((0.05, []), (0.11, ["mocap"]), (0.16, []), (0.22, ["mocap"])):
        wall.now = now
        assert topics(flown.on_timer()) == sent
    assert flown.health.ticks == 0
    flown.receive(encode(command(0.3), 500 * TICK_NS))
    assert flown.on_timer().clock_ns == TICK_NS
    assert flown.on_timer().clock_ns == 2 * TICK_NS


def test_live_after_other_nodes_the_flight_begins_at_last_without_a_command() -> None:
    wall = Wall()
    flown = flight(wall, replace(PARAMS, pace="live", starts_after=("pid",)))
    flown.start()
    flown.on_timer()
    wall.now = FIRST_TIMEOUT_S
    assert flown.on_timer().gave_up.startswith("no command within 10 s of the first frame: ")
    assert flown.on_timer().gave_up == ""


def test_live_vehicles_that_no_command_reached_for_2_s_are_reported_as_locked_until_one_without_thrust() -> (
    None
):
    flown = flight(Wall(), replace(PARAMS, pace="live"), duration=5.0)
    assert flown.locked == ""
    flown.start()
    locks = {}
    for tick in range(300):
        flown.on_timer()
        locks[tick] = flown.locked
        if tick in {220, 250}:
            flown.receive(encode(command(0.3 if tick < 250 else 0.0), tick * TICK_NS))
    names = ", ".join(SCENARIO.names)
    locked = (
        f"{names}: motors locked (at the start, or after 2 s without a command) until a command has no thrust"
    )
    remedy = (
        'start the simulator with -p starts_after:="[mocap_filter, pid]", the nodes to wait for, or with '
        "autostart:=false and call ~/start"
    )
    before = f"{locked}: no command has come: {remedy}"
    after = f"{locked}: restart this node for another flight; if commands came too late, {remedy}"
    assert {tick for tick, text in locks.items() if text == before} == set(range(202, 221))
    assert {tick for tick, text in locks.items() if text == after} == set(range(221, 251))
    assert set(locks.values()) == {"", before, after}


def test_live_a_vehicle_that_commands_do_not_name_is_reported_as_such() -> None:
    flown = flight(Wall(), replace(PARAMS, pace="live"), duration=5.0)
    flown.start()
    first, *others = SCENARIO.names
    one = level_command(0.0, (first,), np.full(1, 0.3))
    for tick in range(300):
        flown.on_timer()
        flown.receive(encode(one, tick * TICK_NS))
    check = "check that the plan and the controller's `vehicles` do"
    assert flown.locked == f"no command names {', '.join(others)}: {check}"


def test_a_command_that_is_not_finite_is_refused_and_the_flight_goes_on() -> None:
    flown = flight(Wall())
    flown.start()
    output = flown.receive(encode(command(float("nan")), 0))
    assert output.clock_ns == TICK_NS
    assert "not finite" in output.refusal
    assert flown.health.refused == 1
    stranger = replace(command(0.3), names=tuple(f"x{name}" for name in SCENARIO.names))
    assert "unknown vehicle" in flown.receive(encode(stranger, TICK_NS)).refusal


def test_with_crtp_the_timer_advances_the_vehicles_by_their_own_firmware() -> None:
    moved: list[tuple[int, ...]] = []
    room = Room(SCENARIO, seed=1)
    flown = RoomFlight(room, PARAMS, 1.0, Wall(), lambda drive: moved.append(drive.shape))
    flown.start()
    assert flown.on_timer().clock_ns == 0
    assert flown.on_timer().clock_ns == TICK_NS
    assert moved == [(len(SCENARIO.names), 7)]
