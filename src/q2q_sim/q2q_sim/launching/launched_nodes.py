"""Nodes of the launch files.

`scenario` flies in the simulator, `real_room` flies vehicles over radios with external motion capture,
`crazyswarm` leaves the radios to Crazyswarm2's server.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from datetime import UTC, datetime
from pathlib import Path

from q2q_control.pid.gains_file import load_gains
from q2q_model.bag import FlightFacts, facts_as_text
from q2q_model.model_files.find_model import find_model
from q2q_model.tunable import ParameterValue
from q2q_model.vehicle.constants import DEFAULT_VEHICLE, Vehicle, firmware_of, vehicle_by_name
from q2q_model.vehicle.thrust_map import STOCK
from q2q_planner.offline.certificate.certified_file import load_plan
from q2q_sim.launching.launch_arguments import YES
from q2q_sim.node_flights.flight_nodes import node_specs
from q2q_sim.node_flights.flight_request import FlightRequest, load_scenario
from q2q_sim.node_flights.running_nodes import RECORDER
from q2q_sim.processes.processes import NodeSpec
from q2q_sim.scenarios import library
from q2q_sim.scenarios.scenario_variants import with_choices, with_firmware

SIMULATOR = "simulator"
ENDS_ALL = frozenset({RECORDER, "trajectory", "radio", "crazyswarm", SIMULATOR})
"""Nodes whose end ends the launch."""


def scenario_nodes(given: Mapping[str, str]) -> list[NodeSpec]:
    """Return the nodes that fly a scenario, and write its plan into the folder.

    Raises:
        ValueError: an unknown scenario, model or value.
    """
    request = FlightRequest(
        scenario=given["scenario"],
        mode=given["mode"],
        controller=given["controller"],
        live=given["pace"] == "live",
        seed=_whole(given["seed"], "seed"),
        model=given["model"],
    )
    folder = folder_of(given["folder"])
    specs = node_specs(load_scenario(request), request, folder, folder / "bag")
    return [*_by_itself(specs), *_viewers(given)]


def room_nodes(given: Mapping[str, str]) -> list[NodeSpec]:
    """Return the nodes that fly a plan in a real room.

    Raises:
        ValueError: a file is not given or missing, the bag exists, the model is unknown.
    """
    folder = _checked(given)
    by_rpyt = given["mode"] == "command"
    facts = FlightFacts(vehicle=given["vehicle"], firmware=given["firmware"], model=given["model"])
    flown: dict[str, ParameterValue] = {"vehicle": given["vehicle"], "firmware": given["firmware"]}
    flown |= {"aware": given["aware"] == YES}
    gains: dict[str, ParameterValue] = asdict(load_gains(given["gains"]))
    pid: list[NodeSpec] = [NodeSpec("q2q_control", "pid", gains | flown | {"live": True})]
    radio: dict[str, ParameterValue] = flown | {"crazyflies": given["crazyflies"], "mode": given["mode"]}
    return [
        *_control_loop(given, folder, facts),
        *(pid if by_rpyt else []),
        NodeSpec("q2q_control", "radio", radio),
        *_viewers(given),
    ]


def crazyswarm_nodes(given: Mapping[str, str]) -> list[NodeSpec]:
    """Return q2q's nodes for Crazyswarm2's server; with `twin` the simulator replaces its radios and room.

    Raises:
        ValueError: a file is not given or missing, the bag exists, the model is unknown.
    """
    folder = _checked(given)
    twin, vehicle = given["twin"] == YES, _bridged_vehicle(given)
    flown: dict[str, ParameterValue] = {"vehicle": vehicle.name, "firmware": firmware_of(vehicle) or STOCK}
    bridge: dict[str, ParameterValue] = {
        "crazyflies": given["crazyflies"],
        "backend": "cflib" if twin else given["backend"],
        "poses_in": "" if twin else "/poses",
        "poses_out": "/poses_filtered",
        "poses_version": _whole(given["poses_version"], "poses_version"),
        "motion_capture": given["motion_capture"],
        "aware": given["aware"] == YES,
    }
    room: dict[str, ParameterValue] = {"scenario": given["scenario"], "crtp": True}
    return [
        *_control_loop(given, folder, _twin_facts(given)),
        NodeSpec("q2q_control", "crazyswarm", bridge | flown),
        *([NodeSpec("q2q_sim", "simulator", room | flown)] if twin else []),
        *_viewers(given),
    ]


def server_arguments(given: Mapping[str, str]) -> dict[str, str]:
    """Return the arguments of Crazyswarm2's launch file; a twin needs no motion capture, but its QoS."""
    twin = given["twin"] == YES
    file = {"motion_capture_yaml_file": given["motion_capture"]} if given["motion_capture"] else {}
    return file | {
        "crazyflies_yaml_file": given["crazyflies"],
        "backend": "cflib" if twin else given["backend"],
        "mocap": "False" if twin else "True",
        "gui": "False",
        "teleop": "False",
    }


def folder_of(asked: str, now: datetime | None = None) -> Path:
    """Return the folder of a launch: the requested one, or a new one named by the time `now`."""
    if asked:
        return Path(asked)
    return Path("out", "launch", (now or datetime.now(UTC).astimezone()).strftime("%Y-%m-%d_%H-%M-%S"))


def _checked(given: Mapping[str, str]) -> Path:
    """Return the folder of a launch after checking that its files exist and its bag does not."""
    for name in ("plan", "crazyflies"):
        if not given[name]:
            raise ValueError(f"give {name}:=FILE")
        if not Path(given[name]).is_file():
            raise ValueError(f"{name}:={given[name]}: no such file")
    tracking = given.get("motion_capture", "")
    if tracking and not Path(tracking).is_file():
        raise ValueError(f"motion_capture:={tracking}: no such file")
    load_plan(Path(given["plan"]))
    find_model(given["model"])
    vehicle_by_name(given["vehicle"] or DEFAULT_VEHICLE, given["firmware"] or STOCK)
    folder = folder_of(given["folder"])
    if (folder / "bag").exists():
        raise ValueError(f"bag {folder / 'bag'} exists: choose another folder or delete it")
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def _twin_facts(given: Mapping[str, str]) -> FlightFacts:
    """Return the metadata of a flight with Crazyswarm2; the vehicle is known if given, or a twin's."""
    twin, vehicle = given["twin"] == YES, _bridged_vehicle(given)
    known = FlightFacts(vehicle.name, firmware_of(vehicle)) if twin or given["vehicle"] else FlightFacts()
    return replace(known, scenario=given["scenario"] if twin else "", model=given["model"])


def _bridged_vehicle(given: Mapping[str, str]) -> Vehicle:
    """Return the vehicle and firmware given, else those of the twin's scenario, else the default ones."""
    if given["twin"] == YES:
        flown = with_choices(library.load(given["scenario"]), given["vehicle"], "")
        return with_firmware(flown, given["firmware"]).vehicle
    return vehicle_by_name(given["vehicle"] or DEFAULT_VEHICLE, given["firmware"] or STOCK)


def _control_loop(given: Mapping[str, str], folder: Path, facts: FlightFacts) -> list[NodeSpec]:
    """Return recorder and nodes of a real room; the trajectory waits for its service call."""
    return [
        NodeSpec(
            "q2q_sim",
            RECORDER,
            {"bag": str(folder / "bag"), "stamps": "receive", "facts": facts_as_text(facts)},
        ),
        NodeSpec("q2q_model", "mocap_filter", {}),
        NodeSpec("q2q_model", "interference", {"model": given["model"]}),
        NodeSpec("q2q_planner", "trajectory", {"plan": given["plan"], "wait": True}),
        NodeSpec("q2q_planner", "replanner", _replanner(given["replan"])),
    ]


def _replanner(replan: str) -> dict[str, ParameterValue]:
    """Return the node's parameters; with "none" it passes setpoints on."""
    return {"law": "safe"} if replan == "safe" else {"law": "paper", "enabled": replan == "paper"}


def _by_itself(specs: Sequence[NodeSpec]) -> list[NodeSpec]:
    """Let the simulator start by itself once the others are ready: a launch file has no flight director."""
    others = tuple(spec.label for spec in specs if spec.executable != SIMULATOR)
    alone: dict[str, ParameterValue] = {"autostart": True, "starts_after": others}
    return [
        replace(spec, parameters={**spec.parameters, **alone}) if spec.executable == SIMULATOR else spec
        for spec in specs
    ]


def _viewers(given: Mapping[str, str]) -> list[NodeSpec]:
    parameters: dict[str, ParameterValue] = {"foxglove": given["foxglove"] == YES}
    return [NodeSpec("q2q_sim", "view", parameters)] if given["view"] == YES else []


def _whole(text: str, name: str) -> int:
    try:
        return int(text)
    except ValueError as wrong:
        raise ValueError(f"{name}:={text}; must be an integer") from wrong
