"""A bag has the faults of its flight, whatever becomes of the scenario's file."""

import warnings
from dataclasses import replace
from pathlib import Path

import pytest
import yaml
from judged_hover import flown, moved

from q2q_model.bag import BagWriter, FlightFacts
from q2q_model.vehicle.constants import CRAZYFLIE_2_0
from q2q_sim.faults.faults import Fault
from q2q_sim.flight_bag.bag_verdict import bag_verdict
from q2q_sim.flight_bag.scenario_facts import flown_faults, scenario_facts
from q2q_sim.loop.flight_blocks import BlockChoices
from q2q_sim.scenarios import library

JUMP = Fault("jump", 0.1 + 0.2, 2.0, ("cf2",), -0.5)


def scenario_file(folder: Path, *faults: Fault) -> Path:
    """Write a scenario of two vehicles with faults; return its file."""
    at = {f"cf{k}": [{"t": t, "pos": [0.0, float(k), 1.0]} for t in (0.0, 10.0)] for k in (1, 2)}
    listed = [{"kind": one.kind, "start": one.start, "duration": one.duration, "size": one.size,
               "vehicles": list(one.vehicles)} for one in faults]  # fmt: skip
    file = folder / "hover.yaml"
    file.write_text(yaml.safe_dump({"vehicles": at, "duration": 10.0, "faults": listed}))
    return file


def bag_of(file: Path, bag: Path) -> FlightFacts:
    """Write an empty bag of a flight of a scenario; return its facts."""
    facts = scenario_facts(library.load(str(file)), BlockChoices(), 0, str(file))
    with BagWriter(bag, facts=facts):
        pass
    return facts


@pytest.mark.parametrize("faults", [(), (JUMP,), (JUMP, Fault("dropout", 3.0))])
def test_a_changed_scenario_does_not_change_the_faults_and_the_verdict_of_a_bag(
    tmp_path: Path, faults: tuple[Fault, ...]
) -> None:
    bag_of(scenario_file(tmp_path, *faults), tmp_path / "bag")
    apart = flown(moved(0.4, 0.6, 1, (0.0, 0.1, 1.0)))
    before = str(bag_verdict(tmp_path / "bag", apart, CRAZYFLIE_2_0))
    scenario_file(tmp_path, Fault("jump", 0.0, 9.0, ("cf1",), 1.0))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert flown_faults(tmp_path / "bag") == faults
        assert str(bag_verdict(tmp_path / "bag", apart, CRAZYFLIE_2_0)) == before
    assert ("displaced" in before) == (JUMP in faults)


def test_a_bag_of_older_software_has_the_faults_of_its_scenario_with_a_note(tmp_path: Path) -> None:
    facts = bag_of(scenario_file(tmp_path, JUMP), tmp_path / "new")
    with BagWriter(tmp_path / "old", facts=replace(facts, faults="")):
        pass
    with pytest.warns(UserWarning, match=r"does not record its faults: those that .*hover.yaml has now"):
        assert flown_faults(tmp_path / "old") == (JUMP,)
    with BagWriter(tmp_path / "kept", facts=replace(facts, faults="", scenario="hover.yaml")):
        pass
    scenario_file(tmp_path / "kept", JUMP)  # in the bag
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert flown_faults(tmp_path / "kept") == (JUMP,)


@pytest.mark.parametrize("words", ["[{kind: flood}]", "[", "3", "[{kind: jump, size: high}]"])
def test_faults_that_cannot_be_read_are_none_with_a_note(tmp_path: Path, words: str) -> None:
    with BagWriter(tmp_path / "bag", facts=FlightFacts(faults=words)):
        pass
    with pytest.warns(UserWarning, match="its faults are unknown: "):
        assert flown_faults(tmp_path / "bag") == ()
