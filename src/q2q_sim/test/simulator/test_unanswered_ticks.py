"""What a flight reports of ticks that no command answers, or commands with stamps of no frame."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from resting_signals import level_command

from q2q_model.signals.stamps import TICK_NS
from q2q_model.signals.values import Names
from q2q_sim.loop.room import Room
from q2q_sim.simulator.command_stamps import CommandStamps
from q2q_sim.simulator.flight_output import Output
from q2q_sim.simulator.room_flight import RoomFlight
from q2q_sim.simulator.simulator_params import SimulatorParams, chosen_scenario

PARAMS = SimulatorParams(resend_period_s=1.5, command_timeout_s=3.0)
SCENARIO = chosen_scenario(PARAMS)
FIRST, SECOND = SCENARIO.names
WALL_NS = 1_796_034_108_352_000_000


@dataclass
class Wall:
    """Wall clock that tests advance."""

    now: float = 0.0

    def __call__(self) -> float:
        """Return the time [s]."""
        return self.now


def flight(wall: Wall, params: SimulatorParams = PARAMS) -> RoomFlight:
    return RoomFlight(Room(SCENARIO, seed=1), params, 10.0, wall)


def answer(flown: RoomFlight, stamp_ns: int, names: Names = SCENARIO.names) -> Output:
    return flown.take(stamp_ns, level_command(0.0, names, np.full(len(names), 0.3)))


def test_in_lockstep_a_tick_that_waits_for_a_second_names_the_vehicles_without_a_command() -> None:
    wall = Wall()
    flown = flight(wall)
    wall.now = 5.0
    assert flown.awaited == ""  # not started
    flown.start()
    wall.now = 5.9
    assert flown.awaited == ""
    wall.now = 6.0
    assert flown.awaited == f"command of {FIRST}, {SECOND} not received: check that a controller runs"
    answer(flown, 0, (FIRST,))
    assert flown.awaited == f"command of {SECOND} not received: check that a controller runs"
    answer(flown, 0, (SECOND,))
    assert flown.awaited == flown.misstamped == ""


def test_in_lockstep_the_first_tick_that_is_given_up_is_reported_and_again_after_an_answer() -> None:
    wall = Wall()
    flown = flight(wall)
    flown.start()
    reports = []
    for tick in range(6):
        if tick == 3:
            answer(flown, tick * TICK_NS)
            continue
        wall.now += 3.0
        reports.append(flown.on_timer().gave_up)
        assert flown.awaited != ""  # the next tick waits as well
    warning = "no command in 3 s (`command_timeout_s`): the vehicles fly without one, a tick every 1.5 s"
    assert reports == [warning, "", "", warning, ""]
    assert (flown.health.ticks, flown.health.missed) == (6, 5)


def test_in_lockstep_commands_with_the_stamp_of_another_clock_are_reported_and_not_as_missing() -> None:
    wall = Wall()
    flown = flight(wall)
    flown.start()
    answer(flown, 0)
    answer(flown, 0)  # of a controller that answers twice
    assert answer(flown, WALL_NS).signals == ()
    assert flown.misstamped == ""
    wall.now = 1.0
    answer(flown, WALL_NS + TICK_NS)
    assert flown.awaited == ""
    assert flown.misstamped == (
        "command: a command is stamped 0.000 s, its frame 0.010 s: stamp each with its frame's stamp"
    )
    answer(flown, TICK_NS)
    answer(flown, WALL_NS)
    wall.now = 2.0
    assert flown.misstamped == (
        "command: a command is stamped 1796034108.352 s, its frame 0.020 s: stamp each with its frame's stamp"
    )


@pytest.mark.parametrize(("stamp_ns", "since"), [(0, 101), (WALL_NS, 0)])
def test_live_stamps_that_are_not_set_or_of_another_clock_are_reported_in_place_of_locked_motors(
    stamp_ns: int, since: int
) -> None:
    flown = flight(Wall(), replace(PARAMS, pace="live"))
    flown.start()
    reported = []
    for tick in range(300):
        flown.on_timer()
        answer(flown, stamp_ns)
        if flown.misstamped:
            reported.append(tick)
        assert flown.locked == flown.awaited == ""
    assert reported == list(range(since, 300))
    answer(flown, 299 * TICK_NS)
    assert flown.misstamped == ""


def test_live_late_commands_and_those_of_a_failsafe_have_no_foreign_stamps() -> None:
    stamps = CommandStamps(exact=False)
    for off in (-1_000_000_000, -7, 0, 7, 1_000_000_000):
        stamps.take(5_000_000_000 + off, 5_000_000_000)
        assert stamps.warning == ""
    for off in (-1_000_000_001, 1_000_000_001):
        stamps.take(5_000_000_000 + off, 5_000_000_000)
        assert stamps.warning == (
            "command: a command is stamped 4.000 s, its frame 5.000 s: stamp each with its frame's stamp"
        )
