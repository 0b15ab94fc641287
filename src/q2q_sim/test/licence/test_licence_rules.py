"""Rules of a licence on made-up flights: setpoints, yaw, idle vehicles, and the end of the program."""

import math
from dataclasses import replace

import numpy as np
import pytest
from licence_logs import LIMITS, command, hover

from q2q_sim.firmware.supervisor.rules import State
from q2q_sim.licence.client_commands.client_command import CommandKind
from q2q_sim.licence.program_process.program_lines import IN_GET_VALUE
from q2q_sim.licence.room.licence_log import ProgramEnd
from q2q_sim.licence.room.trials import LicenceTrial, TrialKind
from q2q_sim.licence.rules.licence_rules import broken_rules


def test_a_sound_flight_breaks_no_rule() -> None:
    assert broken_rules(hover(), LIMITS) == ()
    assert broken_rules(hover(2), LIMITS) == ()


def test_a_vehicle_levelled_out_once_is_not_reported_and_one_levelled_out_often_is() -> None:
    log = hover()
    log.state[300:350] = State.LEVEL_OUT
    assert broken_rules(log, LIMITS) == ()
    log.state[400:450] = State.LEVEL_OUT
    assert [one.rule for one in broken_rules(log, LIMITS)] == ["setpoints"]


@pytest.mark.parametrize(("share", "rules"), [(0.09, []), (0.11, ["setpoints"])])
def test_a_vehicle_may_be_levelled_out_in_a_tenth_of_its_flight(share: float, rules: list[str]) -> None:
    log = hover()
    each = round(0.5 * share * float(log.airborne.sum()))
    for begin in (300, 500):
        log.state[begin : begin + each] = State.LEVEL_OUT
    assert [one.rule for one in broken_rules(log, LIMITS)] == rules


def test_a_yaw_of_more_than_a_turn_a_spin_and_a_flight_without_end_are_reported() -> None:
    turn = command(3.0, CommandKind.PLAN, "go_to", yaw_rad=90.0)
    log = hover()
    assert [one.rule for one in broken_rules(replace(log, commands=(turn,)), LIMITS)] == ["yaw"]
    for sign in (1.0, -1.0):
        spun = hover()
        spun.yaw_rate[400:600] = sign * 8.7  # below 500 deg/s
        spun.yaw_rate[400:419] = sign * 8.8
        assert broken_rules(spun, LIMITS) == ()
        spun.yaw_rate[419] = sign * 8.8
        assert [one.rule for one in broken_rules(spun, LIMITS)] == ["spin"]
    endless = hover()
    endless.pos[800:, 0, 2] = 1.0
    endless.running[800:] = True
    assert [one.rule for one in broken_rules(endless, LIMITS)] == ["end"]


@pytest.mark.parametrize(("yaw", "rules"), [(6.2, []), (-6.2, []), (6.4, ["yaw"]), (-6.4, ["yaw"])])
def test_a_step_of_more_than_a_turn_is_not_in_radians(yaw: float, rules: list[str]) -> None:
    turn = command(3.0, CommandKind.PLAN, "go_to", yaw_rad=yaw)
    assert [one.rule for one in broken_rules(replace(hover(), commands=(turn,)), LIMITS)] == rules


@pytest.mark.parametrize(
    ("step", "is_refused"), [(0.25, False), (float(np.float32(math.pi)), False), (45.0, True)]
)
def test_a_program_may_count_its_turns_in_radians(step: float, *, is_refused: bool) -> None:
    turns = tuple(command(3.0 + 0.1 * k, CommandKind.PLAN, "go_to", yaw_rad=k * step) for k in range(50))
    assert [one.rule for one in broken_rules(replace(hover(), commands=turns), LIMITS)] == [
        "yaw"
    ] * is_refused


def test_what_no_vehicle_can_follow_is_reported_with_its_line() -> None:
    lost = command(3.0, CommandKind.PLAN, "start_trajectory", impossible="trajectory 2, which is not defined")
    found = broken_rules(replace(hover(), commands=(lost,)), LIMITS)
    sentence = "at 3.00 s cf1 is asked for trajectory 2, which is not defined: start_trajectory, line 7"
    assert [one.sentence for one in found] == [sentence]


def test_a_vehicle_that_stays_down_is_reported_with_the_reason() -> None:
    log = hover(2)
    log.pos[:, 1, 2] = 0.0
    refused = replace(command(1.0, CommandKind.PLAN, "takeoff", refused="not armed"), vehicle=1)
    found = broken_rules(replace(log, commands=(log.commands[0], refused)), LIMITS)
    assert [one.sentence for one in found] == [
        "at 1.00 s cf2 is asked to fly and stays on the floor: not armed, takeoff at 1.00 s, line 7"
    ]
    motors = replace(command(1.0, CommandKind.SETPOINT, "setpoint thrust 20000", lifts=False), vehicle=1)
    assert broken_rules(replace(log, commands=(log.commands[0], motors), opened=(0,)), LIMITS) == ()
    silent = broken_rules(replace(log, commands=log.commands[:1]), LIMITS)
    assert [one.why for one in silent] == ["it was never asked to fly"]


@pytest.mark.parametrize(
    ("t", "refused", "rules"),
    [(1.45, "", ["program"]), (8.0, "", ["program", "idle"]), (1.45, "not armed", ["program", "idle"])],
)
def test_a_vehicle_that_the_time_limit_leaves_no_time_to_rise_is_not_idle(
    t: float, refused: str, rules: list[str]
) -> None:
    log = hover(2)
    log.pos[:, :, 2] = 0.0
    asked = command(1.0, CommandKind.PLAN, "takeoff", refused=refused)
    found = broken_rules(replace(log, commands=(asked,), end=ProgramEnd(t, overdue=True)), LIMITS)
    assert {one.rule for one in found} == set(rules)


def test_errors_count_except_on_the_floor_after_a_fault() -> None:
    failed = replace(hover(), end=ProgramEnd(9.9, 1, "KeyError: 'y'", 12))
    assert broken_rules(failed, LIMITS)[0].why == "KeyError: 'y', line 12"
    stale = LicenceTrial(TrialKind.STALE, 0, 5.0)
    assert broken_rules(replace(failed, trial=stale), LIMITS) == ()
    flying = ProgramEnd(5.0, 1, "KeyError: 'y'", 12)
    assert [one.rule for one in broken_rules(replace(failed, trial=stale, end=flying), LIMITS)] == ["program"]


UNKNOWN = ["'Variable motor.m1req not in TOC'", "'colAv.enable not in param TOC'", "'colAv'" + IN_GET_VALUE]


@pytest.mark.parametrize("unknown", UNKNOWN)
def test_of_a_name_that_no_table_has_it_is_said_that_the_emulated_firmware_may_lack_it(unknown: str) -> None:
    failed = replace(hover(), end=ProgramEnd(9.9, 1, f"KeyError: {unknown}", 12))
    assert broken_rules(failed, LIMITS)[0].why.startswith(
        f"KeyError: {unknown}, line 12; the emulated firmware lacks"
    )


def test_a_program_that_does_not_end_is_reported_with_the_lines_on_which_it_waits() -> None:
    end = ProgramEnd(9.9, overdue=True, waiting=(44, 22))
    assert broken_rules(replace(hover(), end=end), LIMITS)[0].why == "it waits on line 44 and line 22"
    outside = replace(end, waiting=(3,), outside=True)
    why = "it waits outside Python's clock, for input, a socket or a process on line 3"
    assert broken_rules(replace(hover(), end=outside), LIMITS)[0].why == why
    caught = replace(end, waiting=(), caught="KeyError: 'y', line 7")
    why = "an earlier callback failed, and cflib caught it: KeyError: 'y', line 7"
    assert broken_rules(replace(hover(), end=caught), LIMITS)[0].why == why
