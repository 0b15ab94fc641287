"""The verdict on a flight names what went wrong, where and when, and nothing that went as it was sent."""

from dataclasses import replace

import numpy as np
import pytest
import yaml

from q2q_model.flights.flight import Flight, of_rows
from q2q_model.model_files.find_model import find_model
from q2q_model.signals.values import Array, CommandStatus
from q2q_model.vehicle.constants import CRAZYFLIE_2_0
from q2q_sim.loop.closed_loop import FlightOptions, fly
from q2q_sim.loop.recording import FlightRecording
from q2q_sim.monitors.flight_judgement import IN_FLIGHT, verdict_of
from q2q_sim.monitors.flight_verdict import FlightVerdict, verdict_line
from q2q_sim.monitors.policies import Circumstances, judge
from q2q_sim.monitors.policies.trace_from_arrays import trace_from_arrays
from q2q_sim.monitors.recording_end import with_lost_ticks, with_planned_end, with_unknown_end
from q2q_sim.replay_page import replay_run
from q2q_sim.scenarios.scenario_document import scenario_from_document

TICKS = 1000
T = 0.01 * np.arange(TICKS)
HOVER = np.broadcast_to([[0.0, 0.0, 1.0], [0.0, 1.0, 1.0]], (TICKS, 2, 3))
AROUND = Circumstances()


def flown(true_pos: Array = HOVER, ref_pos: Array = HOVER, status: Array | None = None) -> Flight:
    """Return a flight of two vehicles over 10 s."""
    empty = FlightRecording(("cf1", "cf2"), TICKS).flight("made")
    given = np.zeros((TICKS, 2)) if status is None else status
    return replace(empty, t=T, true_pos=true_pos, ref_pos=ref_pos, command_status=given)


def moved(since: float, until: float, vehicle: int, to: tuple[float, float, float]) -> Array:
    """Return the hover with one vehicle elsewhere for a while."""
    pos = HOVER.copy()
    pos[(since <= T) & (until > T), vehicle] = to
    return pos


def output(flight: Flight, missed: int | None = None) -> str:
    verdict = verdict_of(flight, AROUND, missed)
    assert verdict.ok == str(verdict).startswith("ok")
    return str(verdict)


def test_a_flight_that_goes_as_it_is_sent_is_ok() -> None:
    assert output(flown()) == "ok: 10.0 s flown to the end"


@pytest.mark.parametrize(
    ("where", "words"),
    [
        ((0.0, 1.0, 0.0), "cf2 hit the floor at 5.6 s"),
        ((0.0, 0.1, 1.0), "cf1 and cf2 collided at 5.6 s, 0.10 m apart"),
        ((0.0, 2.7, 1.0), "cf2 left its path at 5.6 s, 1.70 m from its setpoint"),
    ],
)
def test_what_goes_wrong_is_named_with_who_and_when(where: tuple[float, float, float], words: str) -> None:
    assert output(flown(moved(5.6, 5.8, 1, where))) == words


def test_a_fall_that_no_command_prevents_is_a_failure_when_it_happens() -> None:
    """The policies exempt it until 3.5 s after the push: a vehicle that lies there then has fallen before."""
    push = np.zeros_like(HOVER)
    push[T < 3.0, 0, 2] = -20.0
    while_exempt, longer = (
        replace(flown(moved(1.0, up, 0, (0.0, 0.0, 0.0))), true_eta=push) for up in (6.0, 9.0)
    )
    said = "cf1 hit the floor at 1.0 s (no command could prevent it: policies exempt it)"
    assert output(while_exempt) == said
    assert output(longer) == "cf1 hit the floor at 1.0 s"
    judged = [one.t for one in judge(trace_from_arrays(longer), AROUND, IN_FLIGHT)]
    assert judged == pytest.approx([1.0])


def test_a_failure_that_policies_exempt_does_not_hide_one_that_they_do_not() -> None:
    push = np.zeros_like(HOVER)
    push[T >= 5.9, 1, 2] = -20.0
    away = moved(2.0, 2.5, 1, (0.0, 2.7, 1.0))
    away[(T >= 6.0) & (T < 6.5), 1] = (0.0, 1.0, 2.8)  # further, while its thrust is exceeded
    assert (
        output(replace(flown(away), true_eta=push)) == "cf2 left its path at 2.0 s, 1.70 m from its setpoint"
    )
    away[T < 5.0] = HOVER[0]
    exempt = "cf2 left its path at 6.0 s, 1.80 m from its setpoint (no command could prevent it: "
    assert output(replace(flown(away), true_eta=push)).startswith(exempt)


def test_a_vehicle_sent_to_the_floor_does_not_hit_it() -> None:
    path = HOVER.copy()
    path[:, 1, 2] = np.clip(0.5 * T, 0.0, 1.0)  # a take-off 0.15 m behind its setpoint
    behind = np.maximum(path - [0.0, 0.0, 0.08], 0.0)
    assert output(flown(behind, path)).startswith("ok")
    assert output(flown(path * [1.0, 1.0, 0.0], path)).startswith("cf1 hit the floor at 0.0 s")


def test_commands_that_end_before_the_flight_are_reported_first_as_they_came_first() -> None:
    status = np.zeros((TICKS, 2))
    status[T > 3.995] = np.nan
    fallen = moved(5.0, 20.0, 0, (0.0, 0.0, 0.0))
    words = "commands ended at 4.0 s of 10.0 s; cf1 hit the floor at 5.0 s; 600 of 1000 ticks were missed"
    assert output(flown(fallen, status=status)) == words


def test_commands_of_one_vehicle_that_end_or_lack_are_not_those_of_another() -> None:
    status = np.zeros((TICKS, 2))
    status[T > 8.495, 1] = np.nan
    words = "cf2's commands ended at 8.5 s of 10.0 s; 150 of 1000 ticks of cf2 were missed"
    assert output(flown(status=status)) == words
    status[:, 1] = np.nan  # flown by somebody else: never commanded here
    assert output(flown(status=status)) == "ok: 10.0 s flown to the end"
    status[100:140, 0] = np.nan
    assert output(flown(status=status)) == "40 of 1000 ticks were missed"


def test_commands_end_at_the_time_since_the_first_tick_whatever_the_clock() -> None:
    status = np.zeros((TICKS, 2))
    status[T > 3.995] = np.nan
    for since in (0.0, 1.8e9):
        late = replace(flown(status=status), t=T + since)
        assert output(late).startswith("commands ended at 4.0 s of 10.0 s; 600 of 1000")


@pytest.mark.parametrize(
    ("status", "where", "planned"),
    [
        (CommandStatus.OK, (0.0, 0.1, 1.0), "10"),
        (CommandStatus.CUT, (0.0, 1.0, 0.0), "10"),
        (CommandStatus.LAND, (0.0, 1.0, 0.0), "10"),
        (CommandStatus.OK, (np.nan, np.nan, np.nan), "10"),
        (CommandStatus.OK, (0.0, 1.0, 1.0), "12"),
    ],
)
def test_what_is_said_of_a_flight_is_the_same_whenever_its_clock_began(
    status: CommandStatus, where: tuple[float, float, float], planned: str
) -> None:
    commands = np.zeros((TICKS, 2))
    commands[T > 5.595, 1] = status
    flight = flown(moved(5.6, 6.2, 1, where), status=commands)
    said = []
    for begin in (0.0, 1000.0, 1.8e9):
        later = replace(flight, t=T + begin)
        said.append(str(with_planned_end(verdict_of(later, AROUND), later, planned)))
        cut = str(with_unknown_end(verdict_of(later, AROUND), later))
        assert cut.endswith("the recording was cut off at 10.0 s: its end is unknown")
    assert said[1:] == said[:1] * 2


def test_what_is_said_of_a_part_has_the_times_of_the_whole() -> None:
    status = np.zeros((TICKS, 2))
    status[T > 7.995] = np.nan
    whole = flown(moved(5.6, 5.8, 1, (0.0, 0.1, 1.0)), status=status)
    part = of_rows(whole, slice(500, None))
    said = (
        "cf1 and cf2 collided at 5.6 s, 0.10 m apart; commands ended at 8.0 s of 10.0 s; "
        "200 of 500 ticks were missed"
    )
    assert str(verdict_of(part, AROUND, whole=whole)) == said
    assert replay_run(part, CRAZYFLIE_2_0, whole=whole).verdict.endswith(f"; {said}")


def test_a_part_of_a_flight_is_not_flown_to_the_end() -> None:
    whole = flown()
    part = of_rows(whole, slice(0, 500))
    said = "ok: 5.0 s judged, a part of the flight"
    assert str(verdict_of(part, AROUND, whole=whole)) == said
    assert replay_run(part, CRAZYFLIE_2_0, whole=whole).verdict.endswith(f"; {said}")
    assert replay_run(flown(), CRAZYFLIE_2_0).verdict.endswith("; ok: 10.0 s flown to the end")


def test_a_hundredth_of_the_ticks_may_be_missed_and_no_more() -> None:
    assert output(flown(), missed=10).startswith("ok")
    assert output(flown(), missed=11) == "11 of 1000 ticks were missed"
    assert output(flown(), missed=999).startswith("999 of 1000")


def test_ticks_without_a_command_are_counted_where_nobody_else_counted_them() -> None:
    status = np.zeros((TICKS, 2))
    status[100:140] = np.nan
    assert output(flown(status=status)) == "40 of 1000 ticks were missed"


def test_an_emergency_stop_and_a_blind_landing_are_reported() -> None:
    cut = np.zeros((TICKS, 2))
    cut[T > 6.995] = CommandStatus.CUT
    assert output(flown(status=cut)) == "cf1's motors were cut at 7.0 s; cf2's motors were cut at 7.0 s"
    landing = np.zeros((TICKS, 2))
    landing[(T > 6.995) & (T < 9.495), 1] = CommandStatus.LAND
    assert output(flown(status=landing)).startswith("ok")  # seen again before it was down
    assert output(flown(moved(8.0, 20.0, 1, (0.0, 1.0, 0.0)), status=landing)) == "cf2 landed blind at 8.0 s"


def test_a_vehicle_that_is_flown_blind_to_the_end_is_reported() -> None:
    """Above the floor, where a landing has not ended; level flight after a dropout may still end well."""
    status = np.zeros((TICKS, 2))
    status[T >= 8.995, 1] = CommandStatus.LEVEL
    assert output(flown(status=status)) == "ok: 10.0 s flown to the end"
    status[T >= 9.495, 1] = CommandStatus.LAND
    assert output(flown(status=status)) == "cf2 was flown blind from 9.0 s to the end"
    status[T < 8.995, 1] = CommandStatus.LEVEL
    status[T >= 9.495, 1] = CommandStatus.LEVEL
    assert output(flown(status=status)) == "cf2 was never measured"
    down = moved(3.0, 20.0, 1, (0.0, 1.0, 0.0))
    status[T >= 3.0, 1] = CommandStatus.LAND
    assert output(flown(down, status=status)) == "cf2 was never measured; cf2 landed blind at 3.0 s"
    status[T >= 3.0, 1] = CommandStatus.CUT
    assert output(flown(down, status=status)) == "cf2 was never measured; cf2's motors were cut at 3.0 s"
    status[:, 1] = CommandStatus.CUT
    assert output(flown(status=status)) == "cf2's motors were cut at 0.0 s"


def test_a_part_in_which_a_vehicle_is_blind_is_no_failure_of_a_flight_in_which_it_was_seen_again() -> None:
    status = np.zeros((TICKS, 2))
    status[(T >= 2.995) & (T < 4.995), 1] = CommandStatus.LEVEL
    status[(T >= 3.995) & (T < 4.995), 1] = CommandStatus.LAND
    whole = flown(status=status)
    assert output(whole) == "ok: 10.0 s flown to the end"
    for rows, length in ((slice(0, 450), 4.5), (slice(320, 380), 0.6), (slice(420, 450), 0.3)):
        said = f"ok: {length} s judged, a part of the flight"
        assert str(verdict_of(of_rows(whole, rows), AROUND, whole=whole)) == said
    to_the_end = flown(status=np.where(T[:, None] >= 8.995, [0, CommandStatus.LAND], 0))
    said = "cf2 was flown blind from 9.0 s to the end"
    assert str(verdict_of(of_rows(to_the_end, slice(500, None)), AROUND, whole=to_the_end)) == said
    level = flown(status=np.where(T[:, None] >= 8.995, [0, CommandStatus.LEVEL], 0))
    said = "ok: 0.5 s judged, a part of the flight"
    assert str(verdict_of(of_rows(level, slice(950, None)), AROUND, whole=level)) == said


def test_commands_that_come_again_after_a_part_have_not_ended() -> None:
    status = np.zeros((TICKS, 2))
    status[(T >= 2.995) & (T < 3.695)] = np.nan
    whole = flown(status=status)
    said = "70 of 370 ticks were missed"
    assert str(verdict_of(of_rows(whole, slice(0, 370)), AROUND, whole=whole)) == said


def test_what_was_not_recorded_is_not_judged_and_reported() -> None:
    nowhere = np.full_like(HOVER, np.nan)
    no_plan = output(flown(ref_pos=nowhere))
    unjudged = "floor and setpoint_error (no reference recorded)"
    assert no_plan == f"ok: 10.0 s flown to the end; not judged: {unjudged}"
    assert "floor, setpoint_error and distances" in output(flown(true_pos=nowhere))
    assert "missed ticks" in output(flown(status=np.full((TICKS, 2), np.nan)))


def test_a_vehicle_without_positions_for_a_while_is_not_judged_then() -> None:
    nan = (np.nan, np.nan, np.nan)
    message = "ok: 10.0 s flown to the end; not judged: cf2 from 3.0 to 8.0 s (no position recorded)"
    assert output(flown(moved(3.0, 8.0, 1, nan))) == message
    assert output(flown(moved(9.0, 20.0, 0, nan))).endswith("cf1 from 9.0 to 10.0 s (no position recorded)")
    assert output(flown(moved(3.0, 3.4, 1, nan))) == "ok: 10.0 s flown to the end"


def test_the_filtered_positions_are_judged_where_nobody_knows_the_truth() -> None:
    recorded = flown(true_pos=np.full_like(HOVER, np.nan))
    fallen = replace(recorded, pos=moved(5.6, 5.8, 1, (0.0, 1.0, 0.0)))
    assert output(fallen) == "cf2 hit the floor at 5.6 s"


def test_a_vehicle_that_was_never_seen_yet_is_nowhere_and_not_on_the_floor() -> None:
    """The filter puts it at the origin, here below cf1."""
    unknown = flown(true_pos=np.full_like(HOVER, np.nan))
    late = replace(unknown, pos=moved(0.0, 0.8, 1, (0.0, 0.0, 0.0)))
    seen = replace(late, mocap_pos=moved(0.0, 0.8, 1, (np.nan, np.nan, np.nan)))
    assert output(seen) == (
        "ok: 10.0 s flown to the end; not judged: cf2 from 0.0 to 0.8 s (no position recorded)"
    )
    fallen = replace(seen, pos=moved(5.6, 5.8, 1, (0.0, 1.0, 0.0)))
    assert output(fallen).startswith("cf2 hit the floor at 5.6 s")


def test_a_lost_vehicle_is_not_where_it_was_last() -> None:
    """The filter holds its position, here at its setpoint, whatever becomes of it."""
    unknown = flown(true_pos=np.full_like(HOVER, np.nan))
    lost = replace(unknown, pos=HOVER, mocap_pos=moved(4.0, 10.0, 1, (np.nan, np.nan, np.nan)))
    said = output(lost)
    assert said.startswith("ok: 10.0 s flown to the end; not judged: cf2 from 4.3 to 10.0 s")


@pytest.mark.parametrize(("planned", "said"), [
    ("50", "the flight ended at 10.0 s of 50.0 s, before its end"),
    ("10.4", "ok: 10.0 s flown to the end"),
    ("10", "ok: 10.0 s flown to the end"),
    ("", "ok: 10.0 s flown to the end"),
    ("nan", "ok: 10.0 s flown to the end"),
    ("long", "ok: 10.0 s flown to the end"),
])  # fmt: skip
def test_a_flight_that_was_to_last_longer_is_not_ok(planned: str, said: str) -> None:
    recorded = flown()
    assert str(with_planned_end(verdict_of(recorded, AROUND, 0), recorded, planned)) == said


def test_several_flights_are_reported_in_one_line_by_their_names() -> None:
    fine = FlightVerdict(5.0)
    assert verdict_line([("aware", fine)]) == "verdict: ok: 5.0 s flown to the end"
    fallen = verdict_of(flown(moved(5.6, 5.8, 1, (0.0, 1.0, 0.0))), AROUND)
    line = verdict_line([("aware", fine), ("ignoring", fallen)])
    assert line == "verdict: aware: ok: 5.0 s flown to the end | ignoring: cf2 hit the floor at 5.6 s"


@pytest.mark.parametrize(("mode", "falls"), [("ignoring", True), ("aware", False)])
def test_a_hover_under_another_by_the_soft_loop_falls_where_the_downwash_is_ignored(
    mode: str, falls: bool
) -> None:
    """At rest K_p 0.81 gives way by eta / K_p = 2.5 / 0.81 = 3.1 m: far below the floor from 1 m."""
    above, below = ([[0.0, 0.0, z]] * 2 for z in (1.5, 1.0))
    vehicles = {
        name: [{"t": t, "pos": pos} for t, pos in zip((0.0, 5.0), path, strict=True)]
        for name, path in (("cf1", above), ("cf2", below))
    }
    document = yaml.safe_load("{duration: 5.0, wake: measured, model: measured_law}") | {"vehicles": vehicles}
    scenario = scenario_from_document("hover", document)
    options = FlightOptions(
        mode="ignoring" if mode == "ignoring" else "aware", model=find_model(scenario.model).interaction
    )
    verdict = str(verdict_of(fly(scenario, options), Circumstances(vehicle=scenario.vehicle)))
    assert verdict.startswith("cf2 hit the floor at" if falls else "ok")


def test_ticks_that_the_recording_lacks_are_named() -> None:
    flight = flown()
    whole = verdict_of(flight, AROUND, 0)
    assert with_lost_ticks(whole, flight, TICKS) == whole
    lacking = str(with_lost_ticks(whole, flight, TICKS + 160))
    assert "not judged: 160 of 1160 ticks, which the recording lacks" in lacking
