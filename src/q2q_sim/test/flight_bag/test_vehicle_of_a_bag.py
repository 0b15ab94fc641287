"""A recorded flight of a 0.65 kg vehicle is measured and judged as such, whoever names the vehicle."""

import json
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import pytest

from q2q_model.bag import BagWriter, FlightFacts
from q2q_model.model_files.find_model import find_model
from q2q_model.signals.layout import Signal
from q2q_sim.commands import policies, replay_page, report
from q2q_sim.loop.closed_loop import FlightOptions, fly
from q2q_sim.node_flights.flight_request import FlightRequest, facts_of
from q2q_sim.scenarios import library
from q2q_sim.scenarios.scenario import Scenario

SCENARIO = replace(library.load("table6"), duration=3.0)
REFUSAL = "times the weight of crazyflie_2_0; must be 0.5 to 2 times: name the vehicle with --vehicle"


def recorded(folder: Path, facts: FlightFacts | None, scenario: Scenario = SCENARIO) -> Path:
    """Return the bag of a flight, by default of the first seconds of table6."""
    with BagWriter(folder, facts=facts) as bag:

        def hear(topic: str, stamp_ns: int, signal: Signal) -> None:
            bag.write_signal(f"/{topic}", stamp_ns, signal)

        fly(scenario, FlightOptions(model=find_model(scenario.model).interaction, on_signal=hear))
    return folder


@pytest.fixture(scope="module")
def bag_with_facts(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a bag that says what flew, as `fly` records it."""
    facts = facts_of(SCENARIO, FlightRequest("table6"))
    return recorded(tmp_path_factory.mktemp("facts") / "flight", facts)


@pytest.fixture(scope="module")
def silent(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the same flight in a bag that says nothing."""
    return recorded(tmp_path_factory.mktemp("silent") / "flight", None)


def numbers(bag: Path, folder: Path, monkeypatch: pytest.MonkeyPatch, *more: str) -> dict[str, object]:
    """Return what `report` measures of a bag."""
    monkeypatch.setattr("q2q_sim.report.figures.KINDS", {})
    out = folder / "report.json"
    assert report.main([str(bag), "--out", str(folder / "page"), "--json", str(out), *more]) == 0
    read: dict[str, object] = json.loads(out.read_text())
    return read


def test_a_report_needs_no_vehicle_where_the_bag_names_it(
    bag_with_facts: Path,
    silent: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    by_name = numbers(silent, tmp_path, monkeypatch, "--vehicle", "textbook_065")
    capsys.readouterr()
    assert numbers(bag_with_facts, tmp_path, monkeypatch) == by_name
    assert not capsys.readouterr().err
    light = replace(library.load("table2_1"), duration=3.0)
    numbers(recorded(tmp_path / "light", None, light), tmp_path, monkeypatch)
    assert "does not name its vehicle: crazyflie_2_0 is assumed" in capsys.readouterr().err
    assert "crazyflie_2_0 is assumed" in (tmp_path / "page" / "index.html").read_text()


@pytest.mark.parametrize(("command", "status"), [(report, 1), (replay_page, 1), (policies, 2)])
def test_a_vehicle_that_the_commands_do_not_carry_is_refused(
    command: ModuleType, status: int, silent: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = [] if command is policies else ["--out", str(tmp_path / "page.html")]
    assert command.main([str(silent), *out]) == status
    assert REFUSAL in capsys.readouterr().err
    assert command.main([str(silent), *out, "--vehicle", "textbook_065"]) == 0


def test_policies_judge_a_bag_by_the_vehicle_it_names(
    bag_with_facts: Path, silent: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert policies.main([str(bag_with_facts)]) == 0
    assert not capsys.readouterr().err
    assert policies.main([str(silent)]) == 2
    assert "crazyflie_2_0 is assumed" in capsys.readouterr().err
    assert policies.main([str(bag_with_facts), "--vehicle", "crazyflie_2_0"]) == 2
    assert REFUSAL in capsys.readouterr().err


def test_a_scenario_is_for_its_faults_and_its_vehicle_is_taken_for_a_bag_that_names_none_only(
    bag_with_facts: Path, silent: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert policies.main([str(bag_with_facts), "--scenario", "stack3"]) == 0  # of Crazyflies
    assert not capsys.readouterr().err
    assert policies.main([str(silent), "--scenario", "table6"]) == 0
    expected = f"policies: {silent} does not name its vehicle: textbook_065 of the scenario is assumed; "
    assert capsys.readouterr().err == f"{expected}name it with --vehicle (in Python vehicle=)\n"
    assert policies.main([str(silent), "--scenario", "table6", "--vehicle", "crazyflie_2_0"]) == 2
    assert REFUSAL in capsys.readouterr().err
    assert policies.main([str(silent), "--scenario", "table6", "--vehicle", "crazyfly"]) == 2
    assert "unknown vehicle 'crazyfly'" in capsys.readouterr().err
