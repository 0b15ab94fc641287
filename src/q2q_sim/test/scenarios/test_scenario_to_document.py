"""The document of a scenario gives that scenario again, through the text of a file."""

from dataclasses import replace

import pytest
import yaml

from q2q_sim.faults.faults import Fault
from q2q_sim.scenarios import library
from q2q_sim.scenarios.scenario import Scenario
from q2q_sim.scenarios.scenario_document import scenario_from_document
from q2q_sim.scenarios.scenario_to_document import document_of
from q2q_sim.scenarios.scenario_variants import with_air


def read_again(scenario: Scenario) -> Scenario:
    """Return the scenario of a file with the document of another."""
    text = yaml.safe_dump(document_of(scenario), sort_keys=False)
    return scenario_from_document(scenario.name, yaml.safe_load(text))


@pytest.mark.parametrize("name", library.names())
def test_every_shipped_scenario_is_that_of_its_document(name: str) -> None:
    scenario = replace(library.load(name), in_air=None)
    assert read_again(scenario) == scenario


def test_a_changed_scenario_is_that_of_its_document() -> None:
    own = with_air(library.load("table6_room"), "room", ("wind",))
    changed = replace(
        own,
        duration=0.1 + 0.2,
        radio=replace(own.radio, latency=1.0 / 30.0),
        faults=(Fault("jump", 1.0, 0.5, own.names[:1], -0.25),),
        overrides={"pid": {"k_p_z": 1.0 / 7.0}},
    )
    assert read_again(changed) == changed


def test_what_no_document_gives_has_none() -> None:
    own = library.load("table6_room")
    assert document_of(replace(own, vehicle=replace(own.vehicle, mass=0.031))) is None


def test_a_document_names_one_type_for_all_vehicles() -> None:
    types = {"cf1": "crazyflie_2_0", "cf2": "crazyflie_2_1"}
    with pytest.raises(
        ValueError, match=r"^vehicle = .*; must be the name of one type, that of all vehicles$"
    ):
        scenario_from_document("mixed", {"vehicle": types, "vehicles": {}})
