"""Collisions and flights in downwash, and whose command caused them."""

from dataclasses import replace
from pathlib import Path

from licence_logs import LIMITS, UP, command, hover

from q2q_sim.licence.client_commands.client_command import CommandKind
from q2q_sim.licence.flight_order import Program
from q2q_sim.licence.licence_flights import Licence
from q2q_sim.licence.licence_reports import junit_xml, report_text
from q2q_sim.licence.room.trials import LicenceTrial, TrialKind
from q2q_sim.licence.rules.licence_rules import broken_rules
from q2q_sim.licence.trial_processes import FlownTrial


def test_vehicles_collide_and_the_lower_one_of_a_stack_flies_in_downwash() -> None:
    log = hover(2)
    log.pos[UP, 1, 1] = 0.1
    assert [one.rule for one in broken_rules(log, LIMITS)] == ["collision"]
    stacked = hover(2)
    stacked.pos[UP, 1] = (0.0, 0.0, 1.5)
    found = broken_rules(stacked, LIMITS)
    assert [one.rule for one in found] == ["downwash"]
    assert found[0].what.startswith("cf1 flies in the downwash of cf2, 0.")
    stacked.pos[UP, 1] = (0.0, 0.3, 1.5)
    assert broken_rules(stacked, LIMITS) == ()


def test_a_vehicle_that_lands_on_another_is_the_cause_of_their_collision() -> None:
    log = hover(2)
    log.pos[300:, 0, 2] = 0.0
    log.pos[700:, 1, 1] = 0.0
    landing = replace(command(7.0, CommandKind.PLAN, "land"), vehicle=1)
    stop = command(9.8, CommandKind.OFF, "high-level stop")
    found = broken_rules(replace(log, commands=(*log.commands, landing, stop)), LIMITS)[0]
    assert (found.rule, found.why) == ("collision", "for cf2, the last command was land at 7.00 s, line 7")


def test_of_two_that_collide_in_flight_the_command_of_each_is_reported() -> None:
    log = hover(2)
    log.pos[UP, 1, 1] = 0.1
    go_to = replace(command(1.5, CommandKind.PLAN, "go_to"), vehicle=1)
    found = broken_rules(replace(log, commands=(*log.commands, go_to)), LIMITS)[0]
    first, second = found.why.split("; ")
    assert first == "for cf1, the last command was takeoff at 1.00 s, line 7"
    assert second == "for cf2, the last command was go_to at 1.50 s, line 7"


def test_a_collision_with_a_vehicle_that_lost_its_link_is_a_remark() -> None:
    log = hover(3)
    log.pos[UP, 1, 1] = 0.1
    lost = replace(log, trial=LicenceTrial(TrialKind.LOST, 1, 4.0))
    (remark,) = broken_rules(lost, LIMITS)
    assert (remark.rule, remark.remark) == ("collision", True)
    assert remark.sentence.startswith("remark: at 2.01 s cf1 and cf2 collide: ")
    flown = FlownTrial(lost.trial, (remark,), lost, 1.0)
    assert flown.passed
    found = Licence(Program(Path("two.py")), (flown,), (), 1.0)
    assert report_text(found).splitlines() == [
        "pass  radio lost, cf2 at 4.0 s",
        f"      {remark.sentence}",
        "PASS two.py: 1 flight in 1 s; 1 remark",
    ]
    assert f"<system-out>{remark.sentence}</system-out>" in junit_xml(found)
    assert "<failure" not in junit_xml(found)
    (elsewhere,) = broken_rules(replace(log, trial=LicenceTrial(TrialKind.LOST, 2, 4.0)), LIMITS)
    assert not elsewhere.remark
    assert not FlownTrial(lost.trial, (remark, elsewhere), lost, 1.0).passed
