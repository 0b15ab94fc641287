"""Fallback phases are reported when vehicles enter them, once for each set of vehicles."""

import numpy as np
import pytest
from guarded_flights import CUT, DEGRADED, HOLD, LAND, LEVEL, NAMES, OK, SATURATED, TICK, fly, guarded
from resting_signals import level_command

from q2q_control.failsafe.phase_changes import LANDED, SETTLED_S, PhaseChanges, cut_reason
from q2q_model.signals.values import Names, SwarmCommand


def command(t: float, *status: int, names: Names = NAMES) -> SwarmCommand:
    zero = np.zeros(len(names))
    return level_command(t, names, zero, status=np.array(status, dtype=np.uint8))


def reported(changes: PhaseChanges, one: SwarmCommand, flights: int = 1) -> list[str]:
    return [str(change) for change in changes.update(one, flights)]


def test_each_phase_is_reported_when_it_begins_and_when_the_controller_flies_again() -> None:
    changes = PhaseChanges()
    steps = ((OK, OK), (HOLD, HOLD), (HOLD, HOLD), (LEVEL, HOLD), (LAND, OK), (CUT, SATURATED))
    assert [reported(changes, command(k * TICK, *status)) for k, status in enumerate(steps)] == [
        [],
        ["cf1, cf2: failsafe HOLD"],
        [],
        ["cf1: failsafe LEVEL"],
        ["cf2: the controller flies again", "cf1: failsafe LAND"],
        ["cf1: failsafe CUT"],
    ]
    assert (changes.active, changes.cut, str(changes)) == (True, ("cf1",), "cf1: failsafe CUT")
    changes.update(command(6 * TICK, CUT, LAND), 1)
    assert changes.brought_down == ("cf2", "cf1")


@pytest.mark.parametrize("status", [OK, SATURATED, DEGRADED])
def test_a_command_of_the_controllers_is_no_phase(status: int) -> None:
    changes = PhaseChanges()
    assert reported(changes, command(0.0, status, status)) == []
    assert (changes.active, changes.cut, str(changes)) == (False, (), "")


def test_one_dropout_after_another_is_reported_once_and_one_after_a_calm_time_anew() -> None:
    changes = PhaseChanges()
    lines = []
    for k in range(0, 100, 2):
        lines += reported(changes, command(k * TICK, HOLD, OK)) + reported(
            changes, command((k + 1) * TICK, OK, OK)
        )
    assert lines == ["cf1: failsafe HOLD", "cf1: the controller flies again"]
    assert reported(changes, command(1.0, OK, HOLD)) == ["cf2: failsafe HOLD"]
    reported(changes, command(1.01, OK, OK))
    assert reported(changes, command(1.1 + SETTLED_S, HOLD, OK)) == ["cf1: failsafe HOLD"]


@pytest.mark.parametrize(
    ("steps", "last"),
    [
        (((HOLD, OK), (OK, OK), (HOLD, OK), (LEVEL, OK), (OK, OK)), ["cf1: failsafe LEVEL"]),
        (((HOLD, HOLD), (OK, OK), (HOLD, OK), (OK, OK)), ["cf1: failsafe HOLD"]),
        (((HOLD, OK), (OK, OK), (HOLD, HOLD), (OK, HOLD)), ["cf1, cf2: failsafe HOLD"]),
    ],
)
def test_that_they_are_flown_again_is_the_last_line_whatever_was_reported_before(
    steps: tuple[tuple[int, int], ...], last: list[str]
) -> None:
    changes = PhaseChanges()
    lines = [line for k, status in enumerate(steps) for line in reported(changes, command(k * TICK, *status))]
    assert lines[-2:] == [*last, "cf1: the controller flies again"]


@pytest.mark.parametrize("resumed", [(), (HOLD,)])
def test_each_landing_is_reported_and_that_they_are_flown_on_after_it(resumed: tuple[int, ...]) -> None:
    """A filter that is killed twice within 10 s lands them twice; the log must not end with a landing."""
    changes = PhaseChanges()
    event = (HOLD, *(LAND,) * LANDED, *resumed, OK)
    steps = (HOLD, OK, *event, *event)
    lines = [line for k, one in enumerate(steps) for line in reported(changes, command(k * TICK, one, OK))]
    flown, landed = ["cf1: failsafe HOLD", "cf1: the controller flies again"], "cf1: failsafe LAND"
    assert lines == [*flown, landed, flown[1], flown[0], landed, flown[1]]


def test_landings_of_a_few_commands_that_come_and_go_are_reported_once() -> None:
    """Two sources of motion capture with clocks of their own land and fly vehicles by turns."""
    changes, lines = PhaseChanges(), []
    for k in range(300):
        lines += reported(changes, command(k * TICK, LAND if k % LANDED else OK, OK))
    assert lines == ["cf1: failsafe LAND", "cf1: the controller flies again"]


def test_a_cut_is_reported_again_in_a_new_flight_beside_the_same_controller() -> None:
    guard, changes = guarded(), PhaseChanges()
    for made in fly(guard, 0, 200):
        assert reported(changes, made) == []
    guard.cut_all()
    assert [line for made in fly(guard, 200, 210) for line in reported(changes, made)] == [
        "cf1, cf2: failsafe CUT"
    ]
    again = [line for made in fly(guard, 0, 20) for line in reported(changes, made, guard.flights)]
    assert again == ["cf1, cf2: failsafe CUT"]


@pytest.mark.parametrize("set_back", [4.0, 60.0])
def test_a_cut_is_reported_once_while_stamps_of_two_clocks_alternate(set_back: float) -> None:
    """A live guard answers ticks of a clock that was set back, and by a timer those that it misses."""
    changes, lines = PhaseChanges(), []
    for k in range(10):
        lines += reported(changes, command(74.0 + k * TICK, CUT, CUT))
        lines += reported(changes, command(74.0 - set_back + k * TICK, CUT, CUT))
    assert lines == ["cf1, cf2: failsafe CUT"]


def test_phases_are_those_of_names_not_of_rows() -> None:
    changes = PhaseChanges()
    changes.update(command(0.0, HOLD, OK), 1)
    assert reported(changes, command(0.01, OK, HOLD, names=("cf2", "cf1"))) == []
    assert reported(changes, command(0.02, LAND, names=("cf3",))) == ["cf3: failsafe LAND"]


def test_a_cut_says_who_gave_it_and_what_to_do() -> None:
    by_call = cut_reason(NAMES, emergency=True)
    assert by_call == "cf1, cf2: motors cut by all/emergency: restart this node to fly"
    assert cut_reason(("cf1",), emergency=False).startswith(
        "cf1: motors cut after cut_after_s without measurements"
    )
