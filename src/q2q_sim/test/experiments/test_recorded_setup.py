"""A recorded flight is flown again by the metadata of its bag, or refused."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml

from q2q_model.bag import FlightFacts, read_flight
from q2q_sim.campaigns.random_runs.campaign_flight import fly_pure, keep_run
from q2q_sim.campaigns.random_runs.random_run import Run, draw_run
from q2q_sim.commands.explain import main
from q2q_sim.experiments.explanation import recorded_setup as setups
from q2q_sim.experiments.explanation.recorded_setup import recorded_setup
from q2q_sim.flight_bag.scenario_facts import flown_scenario, scenario_facts
from q2q_sim.loop.flight_blocks import BlockChoices
from q2q_sim.scenarios import library
from q2q_sim.tools.write_replay import part_of_flight


@pytest.fixture(scope="module")
def kept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the bag of a short campaign run with a replanner, which its metadata do not name."""
    run = draw_run(0)
    document = {**run.document, "duration": 1.5}
    short_run = Run(0, document, replace(run.options, controller="pid", replan="safe"))
    folder = tmp_path_factory.mktemp("kept")
    keep_run(short_run, fly_pure(short_run).signals, folder)
    return folder / "0"


def test_a_bag_is_flown_again_to_the_last_bit(kept: Path) -> None:
    found = recorded_setup(kept)
    assert found.difference < 1e-9
    assert found.setup.seed == 0


def test_of_a_bag_that_ends_early_only_the_recorded_flight_is_explained(
    kept: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = recorded_setup(kept)
    monkeypatch.setattr(setups, "read_flight", lambda bag: part_of_flight(read_flight(bag), 0.0, 0.2))
    found = recorded_setup(kept)
    assert found.difference < 1e-9
    assert found.flight.t[-1] == pytest.approx(0.2)
    np.testing.assert_array_equal(found.flight.true_pos, whole.flight.true_pos[: len(found.flight.t)])


def test_a_bag_that_another_flight_left_is_refused(kept: Path, capsys: pytest.CaptureFixture[str]) -> None:
    metadata = kept / "metadata.yaml"
    text = metadata.read_text()
    metadata.write_text(
        text.replace("mode: aware_unlimited", "mode: ignoring").replace("seed: '0'", "seed: '1'")
    )
    assert main([str(kept)]) == 1
    assert "off its recorded position" in capsys.readouterr().err
    metadata.write_text(text.replace("seed: '0'", "sea: '0'"))
    assert main([str(kept)]) == 1
    assert "its metadata lacks seed" in capsys.readouterr().err
    for wrong in ("0", "nan", "inf", "long"):
        metadata.write_text(text.replace("duration: '1.5'", f"duration: '{wrong}'"))
        assert main([str(kept)]) == 1
        printed = capsys.readouterr().err
        assert printed == f"explain: {kept}: duration '{wrong}' in its metadata; must be above 0 s\n"
    metadata.write_text(text)


@pytest.mark.parametrize("stated", ["    duration: '1'\n", ""])  # none in a bag of older software
def test_a_recording_longer_than_its_flight_is_refused(
    kept: Path, stated: str, capsys: pytest.CaptureFixture[str]
) -> None:
    metadata, scenario = kept / "metadata.yaml", kept.parent / "0.yaml"
    before = metadata.read_text(), scenario.read_text()
    metadata.write_text(before[0].replace("    duration: '1.5'\n", stated))
    scenario.write_text(before[1].replace("duration: 1.5", "duration: 1.0"))
    try:
        assert main([str(kept)]) == 1
    finally:
        metadata.write_text(before[0])
        scenario.write_text(before[1])
    assert capsys.readouterr().err == (
        f"explain: {kept}: recorded until 1.49 s, but its metadata or scenario file now say 1 s: "
        "only flights whose scenario has not been changed can be explained\n"
    )


@pytest.mark.parametrize(
    ("key", "wrong", "told"),
    [
        ("seed", "'\u00b2'", "seed '\u00b2' in its metadata; must be an integer >= 0"),
        ("duration", "'1e9'", "duration = 1000000000.0; must be"),
        ("vehicle", "crazyflie_9", "unknown vehicle 'crazyflie_9'"),
        ("firmware", "old", "unknown firmware 'old'"),
        ("wake", "storm", "unknown wake 'storm'"),
        ("scenario", "gone.yaml", "scenario file gone.yaml"),
    ],
)
def test_errors_in_metadata_name_the_bag(
    kept: Path, key: str, wrong: str, told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    metadata = kept / "metadata.yaml"
    text = metadata.read_text()
    metadata.write_text(re.sub(rf"^    {key}: .*$", f"    {key}: {wrong}", text, flags=re.MULTILINE))
    try:
        assert main([str(kept)]) == 1
    finally:
        metadata.write_text(text)
    assert capsys.readouterr().err.startswith(f"explain: {kept}: {told}")


@pytest.mark.parametrize("written", [("--out",), ("--json", "why.json")])
def test_a_place_that_cannot_be_written_is_refused_before_any_flight(
    kept: Path,
    tmp_path: Path,
    written: tuple[str, ...],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    nowhere = tmp_path / "out"
    nowhere.symlink_to(tmp_path / "gone")
    monkeypatch.setattr(setups, "fly_setup", lambda _: pytest.fail("flown"))
    assert main([str(kept), written[0], str(nowhere.joinpath(*written[1:]))]) == 1
    assert capsys.readouterr().err == f"explain: {nowhere}: File exists\n"


def test_a_scenario_in_a_bag_comes_before_files_of_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    bag = tmp_path / "bags" / "bag"
    facts = FlightFacts(scenario="scenario.yaml", model="none")
    for place, height in ((tmp_path / "bags", 1.0), (tmp_path, 2.0), (bag, 3.0)):
        place.mkdir(exist_ok=True)
        path = [{"t": t, "pos": [0.0, 0.0, height]} for t in (0.0, 1.0)]
        (place / "scenario.yaml").write_text(yaml.safe_dump({"vehicles": {"cf1": path}}))
        assert flown_scenario(facts, bag).waypoints[0].waypoints[0].pos[2] == height


def test_a_scenario_is_that_of_the_metadata() -> None:
    facts = FlightFacts("crazyflie_2_1", "stock", "stack3", "aware", "pid", "", "none", "", "ring", "0")
    flown = flown_scenario(facts, Path())
    assert (flown.vehicle.name, flown.air, flown.model) == ("crazyflie_2_1", "ring", "none")
    in_wake = flown_scenario(replace(facts, air="", wake="paper"), Path())
    assert (in_wake.air, in_wake.wake) == ("", "paper")
    without = flown_scenario(replace(facts, air="room without residual without wind"), Path())
    assert (without.air, without.air_without) == ("room", ("residual", "wind"))
    for stated, length in (("", 40.0), ("47.5", 47.5), ("0.5", 0.5)):  # without one, that of the scenario
        assert flown_scenario(replace(facts, duration=stated), Path()).duration == length


@pytest.mark.parametrize(
    ("duration", "text"), [(36.0, "36"), (1234.5678, "1234.5678"), (0.1234567, "0.1234567")]
)
def test_the_duration_of_a_flight_is_in_its_metadata_to_the_last_digit(duration: float, text: str) -> None:
    facts = scenario_facts(replace(library.load("stack3"), duration=duration), BlockChoices(), 0)
    assert facts.duration == text
