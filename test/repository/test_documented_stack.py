"""The stack that docs/stack.md starts by hand has vehicle and model of the scenario that it flies."""

import yaml
from documentation import blocks, commands
from fresh_checkout import ROOT

from q2q_sim.scenarios import library

PAGE = ROOT / "docs" / "stack.md"


def test_the_stack_started_by_hand_flies_its_own_scenario() -> None:
    (written,) = [block for block in blocks(PAGE) if block.language == "yaml"]
    given = {name: node["ros__parameters"] for name, node in yaml.safe_load(written.text).items()}
    typed = [one.text for one in commands() if ROOT / one.document == PAGE]
    (simulator,) = (line for line in typed if "q2q_sim simulator" in line)
    name = simulator.partition("scenario:=")[2].split()[0]
    assert any(f"scenarios/{name}.yaml --out {given['/**/trajectory']['plan']}" in line for line in typed)
    scenario = library.load(name)
    assert given["/**/pid"]["vehicle"] == scenario.vehicle.name
    assert given["/**/interference"]["model"] == scenario.model
