"""What falls, when and why: the rules of a licence on made-up flights."""

import math
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from q2q_sim.experiments.licence.client_commands.client_command import Asked, ClientCommand, CommandKind
from q2q_sim.experiments.licence.flight_order import Program
from q2q_sim.experiments.licence.guided_trials import trials_after
from q2q_sim.experiments.licence.licence_flights import FlownTrial, Licence
from q2q_sim.experiments.licence.licence_reports import junit_xml, report_text
from q2q_sim.experiments.licence.room.licence_log import LicenceLog, ProgramEnd
from q2q_sim.experiments.licence.room.trials import LicenceTrial, TrialKind
from q2q_sim.experiments.licence.rules.licence_limits import LicenceLimits
from q2q_sim.experiments.licence.rules.licence_rules import broken_rules
from q2q_sim.firmware.supervisor.rules import State

LIMITS = LicenceLimits()
TICKS = 1000
UP = slice(200, 800)
"""Ticks in which the vehicles hover."""


def command(t: float, kind: CommandKind, words: str, **more: object) -> ClientCommand:
    return ClientCommand(t, 0, replace(Asked(kind, words), **more), line=7)


def hover(count: int = 1) -> LicenceLog:
    """Return a sound flight: vehicles 1 m apart rise slowly to 1 m, hover, and land slowly."""
    t = 0.01 * np.arange(1, TICKS + 1)
    height = np.interp(t, [0.0, 1.0, 3.0, 7.0, 9.0, 10.0], [0.0, 0.0, 1.0, 1.0, 0.0, 0.0])
    pos = np.zeros((TICKS, count, 3))
    pos[..., 2] = height[:, None]
    pos[..., 1] = np.arange(count)
    running = pos[..., 2] > 0.0
    asked = [replace(command(1.0, CommandKind.PLAN, "takeoff"), vehicle=row) for row in range(count)]
    return LicenceLog(
        uris=tuple(f"radio://{k}" for k in range(count)),
        trial=LicenceTrial(),
        t=t,
        pos=pos,
        vel=np.gradient(pos, 0.01, axis=0),
        quat=np.tile([0.0, 0.0, 0.0, 1.0], (TICKS, count, 1)),
        yaw_rate=np.zeros((TICKS, count)),
        thrust=np.ones((TICKS, count)),
        running=running,
        state=np.full((TICKS, count), int(State.FLYING)),
        age=np.zeros((TICKS, count)),
        commands=tuple(asked),
        opened=tuple(range(count)),
        end=ProgramEnd(9.9),
    )


def fallen(log: LicenceLog, tick: int = 500) -> LicenceLog:
    """Return a flight whose motors stop at a tick, after which the vehicle falls freely."""
    since = np.maximum(log.t - log.t[tick], 0.0)
    pos, vel = log.pos.copy(), log.vel.copy()
    height = np.minimum(pos[:, 0, 2], 1.0 - 0.5 * 9.81 * since**2)
    pos[:, 0, 2] = np.where(since > 0.0, np.maximum(height, 0.0), pos[:, 0, 2])
    vel[:, 0, 2] = np.where((since > 0.0) & (pos[:, 0, 2] > 0.0), -9.81 * since, 0.0)
    running = log.running.copy()
    running[tick:, 0] = False
    return replace(log, pos=pos, vel=vel, running=running)


def test_a_sound_flight_breaks_no_rule():
    assert broken_rules(hover(), LIMITS) == ()
    assert broken_rules(hover(2), LIMITS) == ()


def test_motors_that_stop_in_the_air_are_blamed_on_the_stop_setpoint_and_its_line():
    stop = command(5.0, CommandKind.OFF, "stop setpoint")
    log = fallen(hover())
    found = broken_rules(replace(log, commands=(*log.commands, stop)), LIMITS)
    assert [one.rule for one in found] == ["motors", "landing"]
    assert found[0].t == pytest.approx(log.t[500])
    assert found[0].why == "stop setpoint at 5.00 s, line 7"
    fall = math.sqrt(2.0 * 9.81 * 1.0)  # from 1 m
    assert f"hits the floor at {fall:.1f}" in found[1].what


def test_a_vehicle_that_motors_drive_onto_the_floor_hits_it_though_it_stays_micrometres_above():
    log = hover()
    log.pos[700:, 0, 2] = np.maximum(1.0 - 0.03 * np.arange(1, 301), 3e-6)
    log.vel[700:, 0, 2] = np.where(log.pos[700:, 0, 2] > 3e-6, -3.0, 0.0)
    (found,) = broken_rules(log, LIMITS)
    assert (found.rule, found.what) == ("landing", "cf1 hits the floor at 3.0 m/s")


def test_motors_that_stop_for_a_packet_between_two_commanders_are_not_reported():
    log = hover()
    log.running[500:504] = False
    assert broken_rules(log, LIMITS) == ()
    log.running[500:505] = False
    assert [(one.rule, one.t) for one in broken_rules(log, LIMITS)] == [("motors", log.t[500])]


def test_motors_that_stop_after_two_seconds_without_setpoint_are_blamed_on_the_silence():
    log = fallen(hover())
    late = log.t >= log.t[500]
    state = np.where(late[:, None], int(State.LOCKED), log.state)
    age = np.where(late, 2.01, 0.0)[:, None]
    ignored = command(4.0, CommandKind.PLAN, "land", refused="setpoints have priority")
    sent = command(3.0, CommandKind.SETPOINT, "setpoint z 1.00 m")
    found = broken_rules(replace(log, state=state, age=age, commands=(sent, ignored)), LIMITS)[0]
    assert "no setpoint came for 2 s after setpoint z 1.00 m at 3.00 s" in found.why
    assert "land at 4.00 s, line 7, was not followed: setpoints have priority" in found.why


def test_a_link_that_an_error_closes_is_blamed_on_the_error():
    zero = replace(command(5.0, CommandKind.OFF, "setpoint of thrust 0"), closing=True)
    log = replace(fallen(hover()), commands=(zero,), end=ProgramEnd(5.1, 1, "KeyError: 'y'", 12))
    why = "the program failed (KeyError: 'y', line 12), which closed the link at 5.00 s"
    assert broken_rules(log, LIMITS)[0].why == why
    closed = replace(log, end=ProgramEnd(5.1))
    assert broken_rules(closed, LIMITS)[0].why == "the closing of the link at 5.00 s, which sends zero thrust"


def test_of_two_commands_that_end_a_flight_the_first_is_the_cause():
    stop = command(5.0, CommandKind.OFF, "stop setpoint")
    relax = command(5.001, CommandKind.RELAX, "notify_setpoint_stop")
    zero = replace(command(5.002, CommandKind.OFF, "setpoint of thrust 0"), closing=True)
    before = command(2.0, CommandKind.OFF, "setpoint of thrust 0")  # it flew on after
    log = replace(fallen(hover()), commands=(before, stop, relax, zero))
    assert broken_rules(log, LIMITS)[0].why == "stop setpoint at 5.00 s, line 7"


def test_a_setpoint_that_the_firmware_does_not_follow_is_the_cause_with_its_reason():
    locked = "no setpoint of thrust 0 has unlocked the thrust"
    before = command(3.0, CommandKind.SETPOINT, "setpoint of thrust 1", refused="the vehicle is not armed")
    rise = command(3.5, CommandKind.PLAN, "takeoff")
    last = command(4.5, CommandKind.SETPOINT, "setpoint of thrust 40000", refused=locked)
    log = fallen(hover())
    found = broken_rules(replace(log, commands=(before, rise, last)), LIMITS)[0]
    assert found.why == f"setpoint of thrust 40000 at 4.50 s, line 7, was not followed: {locked}"
    found = broken_rules(replace(log, commands=(before, rise)), LIMITS)[0]
    assert found.why == "the last command was takeoff at 3.50 s, line 7"


def test_a_command_that_the_vehicle_flew_on_after_is_not_the_cause():
    stop = command(2.0, CommandKind.OFF, "setpoint of thrust 0")
    last = command(4.5, CommandKind.SETPOINT, "setpoint thrust 30000")
    log = fallen(hover())
    found = broken_rules(replace(log, commands=(stop, last)), LIMITS)[0]
    assert found.why == "the last command was setpoint thrust 30000 at 4.50 s, line 7"


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_vehicle_leaves_the_room_through_each_wall_and_the_ceiling(axis: int):
    log = hover()
    size = (*LIMITS.half_room, LIMITS.ceiling)[axis]
    log.pos[400:600, 0, axis] = size + 0.01
    assert [one.rule for one in broken_rules(log, LIMITS)] == ["room"]
    log.pos[400:600, 0, axis] = size - 0.01
    assert broken_rules(log, LIMITS) == ()


def test_a_target_outside_the_room_is_reported_when_it_is_asked_for():
    far = command(3.0, CommandKind.PLAN, "go_to", pos=(0.0, 0.0, 60.0))
    log = hover()
    log.pos[700:, 0, 2] = 3.0
    found = broken_rules(replace(log, commands=(*log.commands, far)), LIMITS)
    assert (found[0].rule, found[0].t) == ("room", 3.0)


@pytest.mark.parametrize(
    ("low", "high"), [((0.0, 0.0, -0.7), (0.0, 0.0, 0.5)), ((0.0,) * 3, (0.0, 3.1, 1.0))]
)
def test_a_plan_that_leads_out_of_the_room_is_reported_though_nobody_flies_it_to_its_end(
    low: tuple[float, ...], high: tuple[float, ...]
) -> None:
    out = command(3.0, CommandKind.PLAN, "spiral", extent=(low, high))
    back = command(3.5, CommandKind.PLAN, "go_to", pos=(0.0, 0.0, 1.0))
    (found,) = broken_rules(replace(hover(), commands=(out, back)), LIMITS)
    assert (found.rule, found.t, found.why) == ("room", 3.0, "spiral, line 7")


@pytest.mark.parametrize(("height", "rules"), [(-0.7, ["room"]), (-0.1, [])])
def test_a_target_below_the_floor_is_reported_unless_it_only_presses_a_landing(
    height: float, rules: list[str]
) -> None:
    below = command(3.0, CommandKind.PLAN, "go_to", pos=(0.0, 0.0, height))
    found = broken_rules(replace(hover(), commands=(below,)), LIMITS)
    assert [one.rule for one in found] == rules


def test_vehicles_collide_and_the_lower_one_of_a_stack_flies_in_downwash():
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


def test_a_vehicle_that_lands_on_another_is_the_cause_of_their_collision():
    log = hover(2)
    log.pos[300:, 0, 2] = 0.0
    log.pos[700:, 1, 1] = 0.0
    landing = replace(command(7.0, CommandKind.PLAN, "land"), vehicle=1)
    stop = command(9.8, CommandKind.OFF, "high-level stop")
    found = broken_rules(replace(log, commands=(*log.commands, landing, stop)), LIMITS)[0]
    assert (found.rule, found.why) == ("collision", "for cf2, the last command was land at 7.00 s, line 7")


def test_of_two_that_collide_in_flight_the_command_of_each_is_reported():
    log = hover(2)
    log.pos[UP, 1, 1] = 0.1
    go_to = replace(command(1.5, CommandKind.PLAN, "go_to"), vehicle=1)
    found = broken_rules(replace(log, commands=(*log.commands, go_to)), LIMITS)[0]
    first, second = found.why.split("; ")
    assert first == "for cf1, the last command was takeoff at 1.00 s, line 7"
    assert second == "for cf2, the last command was go_to at 1.50 s, line 7"


def test_a_vehicle_levelled_out_once_is_not_reported_and_one_levelled_out_often_is():
    log = hover()
    log.state[300:350] = State.LEVEL_OUT
    assert broken_rules(log, LIMITS) == ()
    log.state[400:450] = State.LEVEL_OUT
    assert [one.rule for one in broken_rules(log, LIMITS)] == ["setpoints"]


def test_a_yaw_of_more_than_a_turn_a_spin_and_a_flight_without_end_are_reported():
    turn = command(3.0, CommandKind.PLAN, "go_to", yaw_rad=90.0)
    log = hover()
    assert [one.rule for one in broken_rules(replace(log, commands=(turn,)), LIMITS)] == ["yaw"]
    spun = hover()
    spun.yaw_rate[400:419] = 10.0
    assert broken_rules(spun, LIMITS) == ()
    spun.yaw_rate[419] = 10.0
    assert [one.rule for one in broken_rules(spun, LIMITS)] == ["spin"]
    endless = hover()
    endless.pos[800:, 0, 2] = 1.0
    endless.running[800:] = True
    assert [one.rule for one in broken_rules(endless, LIMITS)] == ["end"]


@pytest.mark.parametrize(
    ("step", "is_refused"), [(0.25, False), (float(np.float32(math.pi)), False), (45.0, True)]
)
def test_a_program_may_count_its_turns_in_radians(step: float, *, is_refused: bool) -> None:
    turns = tuple(command(3.0 + 0.1 * k, CommandKind.PLAN, "go_to", yaw_rad=k * step) for k in range(50))
    assert [one.rule for one in broken_rules(replace(hover(), commands=turns), LIMITS)] == [
        "yaw"
    ] * is_refused


def test_what_no_vehicle_can_follow_is_reported_with_its_line():
    lost = command(3.0, CommandKind.PLAN, "start_trajectory", impossible="trajectory 2, which is not defined")
    found = broken_rules(replace(hover(), commands=(lost,)), LIMITS)
    sentence = "at 3.00 s cf1 is asked for trajectory 2, which is not defined: start_trajectory, line 7"
    assert [one.sentence for one in found] == [sentence]


def test_a_vehicle_that_stays_down_is_reported_with_the_reason():
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


def test_errors_count_except_on_the_floor_after_a_fault():
    failed = replace(hover(), end=ProgramEnd(9.9, 1, "KeyError: 'y'", 12))
    assert broken_rules(failed, LIMITS)[0].why == "KeyError: 'y', line 12"
    stale = LicenceTrial(TrialKind.STALE, 0, 5.0)
    assert broken_rules(replace(failed, trial=stale), LIMITS) == ()
    flying = ProgramEnd(5.0, 1, "KeyError: 'y'", 12)
    assert [one.rule for one in broken_rules(replace(failed, trial=stale, end=flying), LIMITS)] == ["program"]


def test_a_program_that_does_not_end_is_reported_with_the_lines_on_which_it_waits():
    end = ProgramEnd(9.9, overdue=True, waiting=(44, 22))
    assert broken_rules(replace(hover(), end=end), LIMITS)[0].why == "it waits on line 44 and line 22"
    outside = replace(end, waiting=(3,), outside=True)
    why = "it waits outside Python's clock, for input, a socket or a process on line 3"
    assert broken_rules(replace(hover(), end=outside), LIMITS)[0].why == why
    caught = replace(end, waiting=(), caught="KeyError: 'y', line 7")
    why = "a callback failed before, which cflib catches: KeyError: 'y', line 7"
    assert broken_rules(replace(hover(), end=caught), LIMITS)[0].why == why


def test_nothing_is_asked_of_a_vehicle_whose_link_is_lost_and_everything_of_the_others():
    lost = replace(fallen(hover(2)), trial=LicenceTrial(TrialKind.LOST, 0, 4.0))
    assert broken_rules(lost, LIMITS) == ()
    other = replace(lost, trial=LicenceTrial(TrialKind.LOST, 1, 4.0))
    assert {one.rule for one in broken_rules(other, LIMITS)} == {"motors", "landing"}


def test_a_collision_with_a_vehicle_that_lost_its_link_is_a_remark():
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


def test_junit_xml_is_valid_whatever_characters_a_program_ends_with():
    """A message in a terminal's colours, half a pair of UTF-16 (of bytes that are not UTF-8), a bell."""
    error = 'RuntimeError: \x1b[31mno "vehicle" < 2\x1b[0m \udcff\ufffe\x07 \U0001f681'
    log = replace(hover(), end=ProgramEnd(10.0, 1, error, 3), output=error)
    (broken,) = broken_rules(log, LIMITS)
    assert error in broken.sentence
    found = Licence(Program(Path("p\x1b.py")), (FlownTrial(log.trial, (broken,), log, 1.0),), (), 1.0)
    case = ET.fromstring(junit_xml(found).encode()).find("testsuite/testcase")  # noqa: S314  our own
    assert case is not None
    failure, output = case.find("failure"), case.find("system-out")
    assert failure is not None
    assert output is not None
    assert output.text == 'RuntimeError: [31mno "vehicle" < 2[0m  \U0001f681'
    assert output.text in failure.get("message", "")
    assert output.text in (failure.text or "")


def test_faults_strike_the_fastest_vehicle_at_its_fastest_and_the_nearest_pair_at_its_nearest():
    log = hover(2)
    log.vel[500, 1, 0] = 2.0
    log.pos[600, 1, 1] = 0.7
    trials = trials_after(log)
    gap = next(one for one in trials if one.kind == TrialKind.GAP)
    assert (gap.vehicle, gap.start) == (1, pytest.approx(log.t[500]))
    swap = next(one for one in trials if one.kind == TrialKind.SWAP)
    assert ({swap.vehicle, swap.other}, swap.start) == ({0, 1}, pytest.approx(log.t[600]))
    grounded = replace(log, pos=0.0 * log.pos)
    assert trials_after(grounded) == ()


def test_of_vehicles_that_fly_one_after_another_the_fastest_is_hit_at_its_fastest():
    log = hover(3)
    for row, turn in enumerate((slice(100, 400), slice(400, 600), slice(600, 900))):
        height = log.pos[turn, row, 2].copy()
        log.pos[:, row, 2] = 0.0
        log.pos[turn, row, 2] = height
    log.pos[:, 1, 1] = 5.0  # the first is the nearest to the last, at y = 0 and 2 m
    log.vel[700, 2, 0] = 2.0
    swap, lost = (
        next(one for one in trials_after(log) if one.kind == kind)
        for kind in (TrialKind.SWAP, TrialKind.LOST)
    )
    assert (swap.vehicle, swap.other, swap.start) == (2, 0, pytest.approx(log.t[700]))
    assert (lost.vehicle, lost.start) == (2, pytest.approx(log.t[700]))


def test_a_landing_in_the_first_second_is_disturbed_from_the_start():
    log = hover()
    early = replace(log, pos=np.concatenate([log.pos[400:440], 0.0 * log.pos[40:]]))  # in the air until 0.4 s
    trials = trials_after(early)
    starts = [one.start for one in trials if one.kind in {TrialKind.GAP, TrialKind.STALE}]
    assert starts[1::2] == [0.0, 0.0]
    assert min(one.start for one in trials) == 0.0
    stale = [fault for one in trials for fault in one.capture_faults(("cf1",))]
    assert [(fault.kind, fault.start) for fault in stale] == [("stale", starts[2]), ("stale", 0.0)]
    assert [one.start for one in trials_after(log)][1] == pytest.approx(log.t[log.airborne[:, 0]][-1] - 1.0)
