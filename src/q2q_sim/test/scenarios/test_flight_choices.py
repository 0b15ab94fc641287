"""The command line of `fly` asks for the flight that its words name."""

import json
import re
from pathlib import Path

import pytest

from q2q_model.signals.topic_names import PREDICTIONS
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, TEXTBOOK_065, on_firmware
from q2q_sim.air.room_air import TERMS
from q2q_sim.commands.fly import main, parser
from q2q_sim.flight_bag.topics import TYPE_NAMES
from q2q_sim.node_flights.scenario_flight import MEASURED
from q2q_sim.processes.interruption import Interruption
from q2q_sim.scenarios import library
from q2q_sim.scenarios.choices import AIR_TERMS, DISTRIBUTED_TOPIC, TOPICS
from q2q_sim.tools import fly_scenario
from q2q_sim.tools.fly_scenario import fly_with_progress, request_of, scenario_notes, vehicle_change


@pytest.mark.parametrize(
    ("words", "together"),
    [
        ([], True),
        (["--lockstep"], True),
        (["--no-stack"], False),
        (["--live"], False),
        (["--live", "--stack"], True),
        (["--live", "--no-stack"], False),
    ],
)
def test_nodes_share_a_process_in_lockstep_and_have_their_own_live_unless_told_otherwise(
    words: list[str], together: bool
):
    asked = request_of(parser().parse_args(["table6", *words]))
    assert asked.stack is together
    assert asked.live is ("--live" in words)


@pytest.mark.parametrize(
    ("words", "recorded"),
    [
        ([], MEASURED),
        (["--bag", "out/it"], ()),
        (["--bag", "out/it", "--record", "state", "truth"], (*MEASURED, "state")),
    ],
)
def test_what_the_numbers_and_the_verdict_need_is_recorded_whatever_else_is_asked_for(
    words: list[str], recorded: tuple[str, ...]
) -> None:
    assert request_of(parser().parse_args(["table6", *words])).record == recorded


def test_topics_and_terms_on_the_command_line_are_those_of_bags_and_airs() -> None:
    assert tuple(TYPE_NAMES) == TOPICS
    assert PREDICTIONS == DISTRIBUTED_TOPIC
    assert TERMS == AIR_TERMS


def test_predictions_are_recorded_of_a_distributed_flight_only(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["table6", "--controller", "mpc", "--record", PREDICTIONS]
    asked = request_of(parser().parse_args([*words, "--distributed"]))
    assert (asked.distributed, asked.record) == (True, (*MEASURED, PREDICTIONS))
    assert main(words) == 1
    assert "--record predictions without --distributed: give both" in capsys.readouterr().err


def test_the_numbers_of_a_flight_are_written_before_its_table_is_printed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With `fly table6 --json FILE | head -1` printing ends the command."""

    def cut_off(*_: object) -> int:
        raise BrokenPipeError

    for name, value in (("_fly", None), ("runs_json", ["numbers"])):
        monkeypatch.setattr(fly_scenario, name, lambda _, value=value: value)
    monkeypatch.setattr(fly_scenario, "print_flights", cut_off)
    with pytest.raises(BrokenPipeError):
        fly_scenario.run(parser().parse_args(["table6", "--json", str(tmp_path / "numbers.json")]))
    assert json.loads((tmp_path / "numbers.json").read_text()) == ["numbers"]


def test_the_progress_of_a_flight_is_named_as_in_its_table(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def refuse(*_: object) -> None:
        raise ValueError("not flown")

    monkeypatch.setattr(fly_scenario, "fly_through_nodes", refuse)
    monkeypatch.setattr("signal.signal", lambda *_: None)  # Interruption's handlers would remain
    asked = request_of(parser().parse_args(["table6", "--ignoring", "--correct"]))
    with pytest.raises(ValueError, match="not flown"):
        fly_with_progress(asked, tmp_path, tmp_path / "bag", Interruption())
    assert "table6 ignoring, corrected" in capsys.readouterr().err


def test_descriptions_call_vehicles_by_the_names_that_they_fly_under() -> None:
    for name in library.names():
        called = set(re.findall(r"\b(?:cf|Q)\d+\b", library.describe(name)))
        assert called <= set(library.load(name).names), name


def test_the_descriptions_of_all_scenarios_begin_in_one_column(capsys: pytest.CaptureFixture[str]):
    assert main(["--list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    columns = {line.index(library.describe(line.split()[0])) for line in lines}
    assert len(lines) == len(library.names())
    assert len(columns) == 1


def test_a_bag_that_exists_is_refused_before_the_nodes_start(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    assert main(["table6", "--bag", str(tmp_path)]) == 1
    assert capsys.readouterr().err == f"fly: bag {tmp_path} exists: choose another folder or delete it\n"


def test_another_vehicle_is_told_from_the_same_one_on_another_firmware():
    assert vehicle_change(TEXTBOOK_065, CRAZYFLIE_2_0) == "crazyflie_2_0, not textbook_065"
    recorded = on_firmware(CRAZYFLIE_2_0, "stock_2025_02")
    assert vehicle_change(CRAZYFLIE_2_0, recorded) == "crazyflie_2_0 with firmware stock_2025_02, not stock"


@pytest.mark.parametrize(
    ("lines", "words", "notes"),
    [
        ("wake: measured", [], ["wake: measured is replaced by air: room"]),
        (
            "wake: measured\ndisturbance: {air_std: 5.0}",
            [],
            ["wake: measured is replaced by air: room", "disturbance is replaced by air: room"],
        ),
        ("wake: none\ndisturbance: {thrust_gain_min: 1.0}", [], []),
        ("wake: measured\ndisturbance: {air_std: 5.0}", ["--air", "ring"], []),
        ("wake: measured", ["--wake", "none"], []),
    ],
)
def test_what_the_files_own_air_replaces_is_told_and_what_a_choice_replaces_is_not(
    lines: str, words: list[str], notes: list[str], tmp_path: Path
) -> None:
    file = tmp_path / "both.yaml"
    file.write_text(f"{lines}\nair: room\nvehicles: {{cf1: [{{pos: [0, 0, 1]}}, {{pos: [0, 1, 1]}}]}}\n")
    assert scenario_notes(request_of(parser().parse_args([str(file), *words]))) == notes
