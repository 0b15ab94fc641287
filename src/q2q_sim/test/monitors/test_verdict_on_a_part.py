"""A part of a flight is judged by what the whole shows, and a recording that ends early is named."""

from dataclasses import replace

import numpy as np
import pytest
from judged_hover import AROUND, TICKS, T, flown, moved, output

from q2q_model.flights.flight import of_rows
from q2q_model.signals.values import CommandStatus
from q2q_model.vehicle.constants import CRAZYFLIE_2_0
from q2q_sim.monitors.flight_judgement import verdict_of
from q2q_sim.monitors.recording_end import with_lost_ticks, with_planned_end, with_unknown_end
from q2q_sim.replay_page import replay_run


@pytest.mark.parametrize(
    ("status", "where", "planned"),
    [
        (CommandStatus.OK, (0.0, 0.1, 1.0), "10"),
        (CommandStatus.CUT, (0.0, 1.0, 0.0), "10"),
        (CommandStatus.LAND, (0.0, 1.0, 0.0), "10"),
        (CommandStatus.OK, (np.nan, np.nan, np.nan), "10"),
        (CommandStatus.OK, (0.0, 1.0, 1.0), "12"),
        (np.nan, (0.0, 1.0, 1.0), "10"),  # no commands any more
    ],
)
def test_what_is_said_of_a_flight_is_the_same_whenever_its_clock_began(
    status: float, where: tuple[float, float, float], planned: str
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
        "cf1 and cf2 collided at 5.6 s, down to 0.10 m apart; commands ended at 8.0 s of 10.0 s; "
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


def test_a_part_in_which_a_vehicle_is_lost_is_no_failure_of_a_flight_in_which_it_was_seen_again() -> None:
    status = np.zeros((TICKS, 2))
    status[(T >= 2.995) & (T < 4.995), 1] = CommandStatus.LEVEL
    status[(T >= 3.995) & (T < 4.995), 1] = CommandStatus.LAND
    whole = flown(status=status)
    assert output(whole) == "ok: 10.0 s flown to the end"
    for rows, length in ((slice(0, 450), 4.5), (slice(320, 380), 0.6), (slice(420, 450), 0.3)):
        said = f"ok: {length} s judged, a part of the flight"
        assert str(verdict_of(of_rows(whole, rows), AROUND, whole=whole)) == said
    to_the_end = flown(status=np.where(T[:, None] >= 8.995, [0, CommandStatus.LAND], 0))
    said = "cf2 flew without measurements from 9.0 s to the end"
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


def test_ticks_that_the_recording_lacks_are_named() -> None:
    flight = flown()
    whole = verdict_of(flight, AROUND, 0)
    assert with_lost_ticks(whole, flight, TICKS) == whole
    lacking = str(with_lost_ticks(whole, flight, TICKS + 160))
    assert "not judged: 160 of 1160 ticks missing from the recording" in lacking
