"""Motors that stop in the air, and what they are blamed on."""

import math
from dataclasses import replace

import numpy as np
import pytest
from licence_logs import LIMITS, command, fallen, hover

from q2q_sim.firmware.supervisor.rules import State
from q2q_sim.licence.client_commands.client_command import CommandKind
from q2q_sim.licence.room.licence_log import ProgramEnd
from q2q_sim.licence.room.trials import LicenceTrial, TrialKind
from q2q_sim.licence.rules.licence_rules import broken_rules


def test_motors_that_stop_in_the_air_are_blamed_on_the_stop_setpoint_and_its_line() -> None:
    stop = command(5.0, CommandKind.OFF, "stop setpoint")
    log = fallen(hover())
    found = broken_rules(replace(log, commands=(*log.commands, stop)), LIMITS)
    assert [one.rule for one in found] == ["motors", "landing"]
    assert found[0].t == pytest.approx(log.t[500])
    assert found[0].why == "stop setpoint at 5.00 s, line 7"
    fall = math.sqrt(2.0 * 9.81 * 1.0)  # from 1 m
    assert f"hits the floor at {fall:.1f}" in found[1].what


def test_a_vehicle_that_motors_drive_onto_the_floor_hits_it_though_it_stays_micrometres_above() -> None:
    log = hover()
    log.pos[700:, 0, 2] = np.maximum(1.0 - 0.03 * np.arange(1, 301), 3e-6)
    log.vel[700:, 0, 2] = np.where(log.pos[700:, 0, 2] > 3e-6, -3.0, 0.0)
    (found,) = broken_rules(log, LIMITS)
    assert (found.rule, found.what) == ("landing", "cf1 hits the floor at 3.0 m/s")


def test_motors_that_stop_for_a_packet_between_two_commanders_are_not_reported() -> None:
    log = hover()
    log.running[500:504] = False
    assert broken_rules(log, LIMITS) == ()
    log.running[500:505] = False
    assert [(one.rule, one.t) for one in broken_rules(log, LIMITS)] == [("motors", log.t[500])]


def test_motors_that_stop_after_two_seconds_without_setpoint_are_blamed_on_the_silence() -> None:
    log = fallen(hover())
    late = log.t >= log.t[500]
    state = np.where(late[:, None], int(State.LOCKED), log.state)
    age = np.where(late, 2.01, 0.0)[:, None]
    ignored = command(4.0, CommandKind.PLAN, "land", refused="setpoints have priority")
    sent = command(3.0, CommandKind.SETPOINT, "setpoint z 1.00 m")
    found = broken_rules(replace(log, state=state, age=age, commands=(sent, ignored)), LIMITS)[0]
    assert "no setpoint came for 2 s after setpoint z 1.00 m at 3.00 s" in found.why
    assert "land at 4.00 s, line 7, was not followed: setpoints have priority" in found.why


def test_a_link_that_an_error_closes_is_blamed_on_the_error() -> None:
    zero = replace(command(5.0, CommandKind.OFF, "setpoint of thrust 0"), closing=True)
    log = replace(fallen(hover()), commands=(zero,), end=ProgramEnd(5.1, 1, "KeyError: 'y'", 12))
    why = "the program failed (KeyError: 'y', line 12), which closed the link at 5.00 s"
    assert broken_rules(log, LIMITS)[0].why == why
    closed = replace(log, end=ProgramEnd(5.1))
    assert broken_rules(closed, LIMITS)[0].why == "the closing of the link at 5.00 s, which sends zero thrust"


def test_of_two_commands_that_end_a_flight_the_first_is_the_cause() -> None:
    stop = command(5.0, CommandKind.OFF, "stop setpoint")
    relax = command(5.001, CommandKind.RELAX, "notify_setpoint_stop")
    zero = replace(command(5.002, CommandKind.OFF, "setpoint of thrust 0"), closing=True)
    before = command(2.0, CommandKind.OFF, "setpoint of thrust 0")  # it flew on after
    log = replace(fallen(hover()), commands=(before, stop, relax, zero))
    assert broken_rules(log, LIMITS)[0].why == "stop setpoint at 5.00 s, line 7"


def test_a_setpoint_that_the_firmware_does_not_follow_is_the_cause_with_its_reason() -> None:
    locked = "no setpoint of thrust 0 has unlocked the thrust"
    before = command(3.0, CommandKind.SETPOINT, "setpoint of thrust 1", refused="the vehicle is not armed")
    rise = command(3.5, CommandKind.PLAN, "takeoff")
    last = command(4.5, CommandKind.SETPOINT, "setpoint of thrust 40000", refused=locked)
    log = fallen(hover())
    found = broken_rules(replace(log, commands=(before, rise, last)), LIMITS)[0]
    assert found.why == f"setpoint of thrust 40000 at 4.50 s, line 7, was not followed: {locked}"
    found = broken_rules(replace(log, commands=(before, rise)), LIMITS)[0]
    assert found.why == "the last command was takeoff at 3.50 s, line 7"


def test_a_command_that_the_vehicle_flew_on_after_is_not_the_cause() -> None:
    stop = command(2.0, CommandKind.OFF, "setpoint of thrust 0")
    last = command(4.5, CommandKind.SETPOINT, "setpoint thrust 30000")
    log = fallen(hover())
    found = broken_rules(replace(log, commands=(stop, last)), LIMITS)[0]
    assert found.why == "the last command was setpoint thrust 30000 at 4.50 s, line 7"


def test_nothing_is_asked_of_a_vehicle_whose_link_is_lost_and_everything_of_the_others() -> None:
    lost = replace(fallen(hover(2)), trial=LicenceTrial(TrialKind.LOST, 0, 4.0))
    assert broken_rules(lost, LIMITS) == ()
    other = replace(lost, trial=LicenceTrial(TrialKind.LOST, 1, 4.0))
    assert {one.rule for one in broken_rules(other, LIMITS)} == {"motors", "landing"}
