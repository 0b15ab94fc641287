"""Launch files start nodes that exist, with parameters they declare; where launch is, the files load."""

import importlib.util
from pathlib import Path

import pytest
from fresh_checkout import ROOT

from q2q_planner import plan_file
from q2q_sim.ros.node_survey import NodeInterface, survey
from q2q_sim.tools.launching import (
    ROOM_ARGUMENTS,
    SCENARIO_ARGUMENTS,
    defaults,
    room_nodes,
    scenario_nodes,
)
from q2q_sim.tools.processes import NodeSpec, find_executable

FILES = sorted((ROOT / "src").glob("*/launch/*.launch.py"))


@pytest.fixture(scope="module")
def nodes() -> list[NodeInterface]:
    return survey()


def declared_by(nodes: list[NodeInterface], spec: NodeSpec) -> set[str]:
    """Return the parameters of the node that a spec starts."""
    found = next(one for one in nodes if (one.package, one.executable) == (spec.package, spec.executable))
    return {parameter.name for parameter, _ in found.parameters}


@pytest.mark.parametrize("controller", ["pid", "mpc"])
def test_a_scenario_starts_nodes_that_exist_with_parameters_they_declare(
    nodes: list[NodeInterface], controller: str, tmp_path: Path
):
    given = defaults(SCENARIO_ARGUMENTS) | {"folder": str(tmp_path), "controller": controller}
    specs = scenario_nodes(given)
    assert controller in {spec.executable for spec in specs}
    for spec in specs:
        assert find_executable(spec.package, spec.executable)
        assert spec.parameters.keys() <= declared_by(nodes, spec), spec.executable
    assert plan_file.load(tmp_path / "plan.json").names == ("cf1", "cf2")


def test_a_launched_simulator_starts_by_itself_and_at_the_pace_asked_for(tmp_path: Path):
    given = defaults(SCENARIO_ARGUMENTS) | {"folder": str(tmp_path), "seed": "7"}
    simulator = next(spec for spec in scenario_nodes(given) if spec.executable == "simulator")
    assert simulator.parameters["autostart"] is True
    assert simulator.parameters["pace"] == "live"
    assert simulator.parameters["seed"] == 7


@pytest.mark.parametrize(("mode", "has_pid"), [("command", True), ("setpoint", False)])
def test_a_real_room_starts_nodes_that_exist_with_parameters_they_declare(
    nodes: list[NodeInterface], mode: str, *, has_pid: bool
):
    given = defaults(ROOM_ARGUMENTS) | {"plan": "p.json", "crazyflies": "c.yaml", "mode": mode}
    specs = room_nodes(given)
    for spec in specs:
        assert find_executable(spec.package, spec.executable)
        assert spec.parameters.keys() <= declared_by(nodes, spec), spec.executable
    started = {spec.executable for spec in specs}
    assert ("pid" in started) == has_pid
    assert "simulator" not in started


@pytest.mark.parametrize("missing", ["plan", "crazyflies"])
def test_a_real_room_without_plan_or_vehicles_says_what_to_give(missing: str):
    given = defaults(ROOM_ARGUMENTS) | {"plan": "p.json", "crazyflies": "c.yaml", missing: ""}
    with pytest.raises(ValueError, match=f"give {missing}:=FILE"):
        room_nodes(given)


def test_every_argument_says_what_it_is_and_defaults_to_an_allowed_value():
    for one in (*SCENARIO_ARGUMENTS, *ROOM_ARGUMENTS):
        assert one.words
        assert not one.choices or one.default in one.choices


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_the_launch_file_loads_and_declares_its_arguments(path: Path):
    pytest.importorskip("launch_ros", reason="launch is not on the package index: needs a sourced ROS 2")
    spec = importlib.util.spec_from_file_location(path.stem.partition(".")[0], path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    wanted = SCENARIO_ARGUMENTS if path.name.startswith("scenario") else ROOM_ARGUMENTS
    told = {one.name for one in module.generate_launch_description().get_launch_arguments()}
    assert told == {one.name for one in wanted}
