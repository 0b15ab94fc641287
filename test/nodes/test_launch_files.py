"""Launch files start nodes that exist, with parameters they declare; where launch is, the files load."""

import importlib.util
from collections.abc import Callable, Sequence
from datetime import UTC, datetime
from pathlib import Path

import pytest
from fresh_checkout import ROOT

from q2q_model.trajectory import plan_file
from q2q_sim.launching.launch_arguments import (
    COMMON_ARGUMENTS,
    CRAZYSWARM_ARGUMENTS,
    ROOM_ARGUMENTS,
    SCENARIO_ARGUMENTS,
    Argument,
    undeclared,
)
from q2q_sim.launching.launched_nodes import (
    ENDS_ALL,
    crazyswarm_nodes,
    folder_of,
    room_nodes,
    scenario_nodes,
    server_arguments,
)
from q2q_sim.loop import flight_blocks
from q2q_sim.node_flights.flight_request import FlightRequest
from q2q_sim.processes.processes import NodeSpec, find_executable
from q2q_sim.ros.node_survey import NodeInterface, survey
from q2q_sim.scenarios import library

FILES = sorted((ROOT / "src").glob("*/launch/*.launch.py"))


def defaults(arguments: Sequence[Argument]) -> dict[str, str]:
    """Return every argument at its default."""
    return {one.name: one.default for one in arguments}


@pytest.fixture(scope="module")
def nodes() -> list[NodeInterface]:
    return survey()


def declared_by(nodes: list[NodeInterface], spec: NodeSpec) -> set[str]:
    """Return the parameters of the node that a spec starts."""
    found = next(one for one in nodes if (one.package, one.executable) == (spec.package, spec.executable))
    return {parameter.declared.name for parameter in found.parameters}


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
    assert simulator.parameters["starts_after"] == (
        "bag_record",
        "mocap_filter",
        "interference",
        "trajectory",
        "replanner",
        "pid",
    )
    assert simulator.parameters["pace"] == "live"
    assert simulator.parameters["seed"] == 7


@pytest.fixture
def room(tmp_path: Path) -> dict[str, str]:
    """Return the files of a real room, and a folder for its bag."""
    plan_file.save(tmp_path / "plan.json", flight_blocks.plan_of(library.load("table6")))
    (tmp_path / "crazyflies.yaml").write_text("robots: {}\n")
    given = {"plan": "plan.json", "crazyflies": "crazyflies.yaml", "folder": "flight"}
    return {name: str(tmp_path / file) for name, file in given.items()}


MADE = {"radio": (ROOM_ARGUMENTS, room_nodes), "crazyswarm": (CRAZYSWARM_ARGUMENTS, crazyswarm_nodes)}
ROOMS = [
    ("radio", {"mode": "command"}, {"pid", "radio"}),
    ("radio", {"mode": "setpoint"}, {"radio"}),
    ("crazyswarm", {}, {"crazyswarm"}),
    ("crazyswarm", {"twin": "true"}, {"crazyswarm", "simulator"}),
]


@pytest.mark.parametrize(("by", "asked", "flown"), ROOMS)
def test_a_real_room_starts_nodes_that_exist_and_a_trajectory_that_waits(
    nodes: list[NodeInterface],
    room: dict[str, str],
    by: str,
    asked: dict[str, str],
    flown: set[str],
):
    arguments, made = MADE[by]
    specs = made(defaults(arguments) | room | asked)
    for spec in specs:
        assert find_executable(spec.package, spec.executable)
        assert spec.parameters.keys() <= declared_by(nodes, spec), spec.executable
    started = {spec.executable: spec for spec in specs}
    assert started.keys() & {"pid", "radio", "crazyswarm", "simulator"} == flown
    assert started["trajectory"].parameters["wait"] is True
    assert ENDS_ALL & started.keys() == {"bag_record", "trajectory", *flown - {"pid"}}


@pytest.mark.parametrize("asked", ["true", "false"])
@pytest.mark.parametrize(("by", "given", "given_to"), [
    ("radio", {"mode": "command"}, {"pid", "radio"}),
    ("radio", {"mode": "setpoint"}, {"radio"}),
    ("crazyswarm", {}, {"crazyswarm"}),
])  # fmt: skip
def test_whether_the_downwash_is_compensated_is_told_to_every_node_that_does(
    room: dict[str, str], by: str, given: dict[str, str], given_to: set[str], asked: str
):
    arguments, made = MADE[by]
    specs = made(defaults(arguments) | room | given | {"aware": asked})
    aware = {spec.executable: spec.parameters["aware"] for spec in specs if "aware" in spec.parameters}
    assert aware == dict.fromkeys(given_to, asked == "true")


def test_the_pid_of_a_real_room_has_the_tuned_gains_unless_others_are_asked_for(room: dict[str, str]):
    given = defaults(ROOM_ARGUMENTS) | room
    for asked, k_p_z, k_i_z in (({}, 10.0, 6.0), ({"gains": "learned"}, 0.81073, 0.0)):
        pid = next(spec for spec in room_nodes(given | asked) if spec.executable == "pid")
        assert (pid.parameters["k_p_z"], pid.parameters["k_i_z"]) == (k_p_z, k_i_z)
    with pytest.raises(ValueError, match="no gains 'mine'"):
        room_nodes(given | {"gains": "mine"})


@pytest.mark.parametrize("by", ["radio", "crazyswarm"])
def test_the_replanner_moves_no_setpoint_unless_asked_to(room: dict[str, str], by: str):
    arguments, made = MADE[by]
    given = defaults(arguments) | room
    assert given["replan"] == "none" == FlightRequest("table6").replan
    paper = {"law": "paper"}
    for asked, parameters in (
        ("none", paper | {"enabled": False}),
        ("paper", paper | {"enabled": True}),
        ("safe", {"law": "safe"}),
    ):
        specs = made(given | {"replan": asked})
        replanner = next(spec for spec in specs if spec.executable == "replanner")
        assert replanner.parameters == parameters


@pytest.mark.parametrize(("by", "twin", "given", "vehicle"), [
    ("radio", "false", "crazyflie_2_1", "crazyflie_2_1"),
    ("crazyswarm", "false", "crazyflie_2_1", "crazyflie_2_1"),
    ("crazyswarm", "false", "", "crazyflie_2_0"),
    ("crazyswarm", "true", "", "textbook_065"),
    ("crazyswarm", "true", "crazyflie_2_1", "crazyflie_2_1"),
])  # fmt: skip
def test_every_node_that_scales_thrust_has_the_same_vehicle_and_firmware(
    room: dict[str, str], by: str, twin: str, given: str, vehicle: str
):
    arguments, made = MADE[by]
    firmware = "stock" if vehicle == "textbook_065" else "stock_2025_09"
    specs = made(defaults(arguments) | room | {"vehicle": given, "firmware": firmware, "twin": twin})
    given_to = [spec.parameters for spec in specs if "vehicle" in spec.parameters]
    assert len(given_to) == (1 if (by, twin) == ("crazyswarm", "false") else 2)
    assert {(one["vehicle"], one["firmware"]) for one in given_to} == {(vehicle, firmware)}
    facts = next(one.parameters["facts"] for one in specs if "facts" in one.parameters)
    assert isinstance(facts, tuple)
    assert (f"vehicle={vehicle}" in facts) == bool(given or twin == "true")


@pytest.mark.parametrize(("given", "flown"), [
    ({}, ("crazyflie_2_0", "thrust_upgrade")),
    ({"firmware": "stock_2025_09"}, ("crazyflie_2_0", "stock_2025_09")),
    ({"vehicle": "crazyflie_2_1"}, ("crazyflie_2_1", "thrust_upgrade")),
    ({"vehicle": "crazyflie_brushless"}, ("crazyflie_brushless", "stock")),  # it has no such firmware
    ({"twin": "false"}, ("crazyflie_2_0", "stock")),
])  # fmt: skip
def test_a_twin_flies_vehicle_and_firmware_of_its_scenario_unless_others_are_given(
    room: dict[str, str], tmp_path: Path, given: dict[str, str], flown: tuple[str, str]
):
    own = tmp_path / "own.yaml"
    points = "vehicles: {cf1: [{t: 0, pos: [0, 0, 1]}, {t: 3, pos: [1, 0, 1]}]}\n"
    own.write_text(f"vehicle: crazyflie_2_0\nfirmware: thrust_upgrade\n{points}")
    asked = {"scenario": str(own), "twin": "true"} | given
    specs = crazyswarm_nodes(defaults(CRAZYSWARM_ARGUMENTS) | room | asked)
    given_to = [spec.parameters for spec in specs if "vehicle" in spec.parameters]
    assert {(one["vehicle"], one["firmware"]) for one in given_to} == {flown}
    facts = next(one.parameters["facts"] for one in specs if "facts" in one.parameters)
    assert isinstance(facts, tuple)
    assert (f"firmware={flown[1]}" in facts) == (asked["twin"] == "true")


def test_a_firmware_that_the_vehicle_does_not_have_is_refused_before_any_node_starts(room: dict[str, str]):
    given = defaults(ROOM_ARGUMENTS) | room | {"vehicle": "crazyflie_brushless", "firmware": "thrust_upgrade"}
    with pytest.raises(
        ValueError, match=r"unknown firmware 'thrust_upgrade' of crazyflie_brushless; choose one of"
    ):
        room_nodes(given)


def test_arguments_that_a_launch_file_does_not_have_are_named_in_a_warning():
    declared = ("plan", "aware")
    assert undeclared(declared, declared) == ""
    warning = undeclared(("plan", "awre", "Plan"), declared)
    assert warning == "ignored: Plan:=, awre:=; arguments are aware, plan"


@pytest.mark.parametrize("made", [room_nodes, crazyswarm_nodes])
def test_files_and_bag_are_looked_at_before_any_node_starts(
    room: dict[str, str], made: Callable[[dict[str, str]], list[NodeSpec]]
):
    given = defaults(ROOM_ARGUMENTS) | defaults(CRAZYSWARM_ARGUMENTS) | room
    for name in ("plan", "crazyflies"):
        with pytest.raises(ValueError, match=f"give {name}:=FILE"):
            made(given | {name: ""})
        with pytest.raises(ValueError, match=f"{name}:=absent: no such file"):
            made(given | {name: "absent"})
    with pytest.raises(ValueError, match="is not a plan"):
        made(given | {"plan": room["crazyflies"]})
    (Path(room["folder"]) / "bag").mkdir(parents=True)
    with pytest.raises(ValueError, match="exists: choose another folder"):
        made(given)


def test_the_server_reads_the_motion_capture_file_that_the_bridge_reads(room: dict[str, str], tmp_path: Path):
    given = defaults(CRAZYSWARM_ARGUMENTS) | room
    assert "motion_capture_yaml_file" not in server_arguments(given)
    file = tmp_path / "motion_capture.yaml"
    with pytest.raises(ValueError, match=f"motion_capture:={file}: no such file"):
        crazyswarm_nodes(given | {"motion_capture": str(file)})
    file.touch()
    given |= {"motion_capture": str(file)}
    bridge = next(spec for spec in crazyswarm_nodes(given) if spec.executable == "crazyswarm")
    assert server_arguments(given)["motion_capture_yaml_file"] == bridge.parameters["motion_capture"]
    assert server_arguments(given)["crazyflies_yaml_file"] == bridge.parameters["crazyflies"]


def test_the_default_folder_is_dated():
    assert folder_of("", datetime(2026, 11, 22, 7, 5, 9, tzinfo=UTC)) == Path(
        "out/launch/2026-11-22_07-05-09"
    )
    assert folder_of("out/mine") == Path("out/mine")


def test_every_argument_says_what_it_is_and_defaults_to_an_allowed_value():
    for one in (*SCENARIO_ARGUMENTS, *ROOM_ARGUMENTS, *CRAZYSWARM_ARGUMENTS, *COMMON_ARGUMENTS):
        assert one.description
        assert not one.choices or one.default in one.choices


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_the_launch_file_loads_and_declares_its_arguments(path: Path):
    pytest.importorskip("launch_ros", reason="launch is not on the package index: needs a sourced ROS 2")
    spec = importlib.util.spec_from_file_location(path.stem.partition(".")[0], path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    of_file = {
        "scenario": SCENARIO_ARGUMENTS,
        "real_room": ROOM_ARGUMENTS,
        "crazyswarm": CRAZYSWARM_ARGUMENTS,
    }
    expected = (*of_file[path.name.partition(".")[0]], *COMMON_ARGUMENTS)
    output = {one.name for one in module.generate_launch_description().get_launch_arguments()}
    assert output == {one.name for one in expected}
