"""Say which nodes a launch file starts, and what its arguments mean; the launch files only pass them on.

Two launch files: `scenario` flies in the simulator, `real_room` flies vehicles over radios by an outside
motion capture. Arguments are words, as `ros2 launch` gives them.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from q2q_model.parameters import ParameterValue
from q2q_model.wiring import PROMISE_S
from q2q_sim.tools.flight import FlightRequest, load_scenario, node_specs
from q2q_sim.tools.processes import NodeSpec

YES, NO = "true", "false"


@dataclass(frozen=True, slots=True)
class Argument:
    """One argument of a launch file."""

    name: str
    default: str
    words: str
    choices: tuple[str, ...] = ()


FOLDER = Argument("folder", "out/launch", "where parameters, plan and bag go; the bag in it must not exist")
VIEW = Argument("view", YES, "show the flight: `scene` for RViz", (YES, NO))
FOXGLOVE = Argument("foxglove", NO, "with view: serve Foxglove on this machine", (YES, NO))
MODEL = Argument("model", "", "interaction model: none, a shipped name, or a .q2q file")

SCENARIO_ARGUMENTS = (
    Argument("scenario", "table6", "scenario name or file; `scripts/fly --list` names them"),
    Argument("mode", "aware", "compensate the draft or not", ("aware", "aware_unlimited", "ignoring")),
    Argument("controller", "pid", "who computes the commands", ("pid", "mpc")),
    Argument("pace", "live", "100 Hz of wall time, or as fast as commands come", ("live", "lockstep")),
    Argument("seed", "0", "seed of everything random"),
    MODEL,
    FOLDER,
    VIEW,
    FOXGLOVE,
)

ROOM_ARGUMENTS = (
    Argument("plan", "", "plan file to fly, made by `ros2 run q2q_planner plan`"),
    Argument("crazyflies", "", "crazyflies.yaml, as Crazyswarm2 reads it"),
    Argument("mode", "command", "attitude and thrust, or full states", ("command", "setpoint")),
    Argument("vehicle", "crazyflie_2_0", "vehicle constants"),
    Argument("mocap", "mocap", "topic of the motion capture (q2q_msgs/MocapFrame)"),
    Argument("model", "measured_law", MODEL.words),
    FOLDER,
    VIEW,
    FOXGLOVE,
)


def scenario_nodes(given: Mapping[str, str]) -> list[NodeSpec]:
    """Return the nodes that fly a scenario; write its plan into the folder.

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
    folder = Path(given["folder"])
    folder.mkdir(parents=True, exist_ok=True)
    specs = node_specs(load_scenario(request), request, folder, folder / "bag")
    return [*map(_at_once, specs), *_viewers(given)]


def room_nodes(given: Mapping[str, str]) -> list[NodeSpec]:
    """Return the nodes that fly a plan in a real room.

    Raises:
        ValueError: no plan or no crazyflies.yaml is given.
    """
    for name in ("plan", "crazyflies"):
        if not given[name]:
            raise ValueError(f"give {name}:=FILE")
    by_stick = given["mode"] == "command"
    promised: dict[str, ParameterValue] = {"promise_s": PROMISE_S}
    flown: dict[str, ParameterValue] = {"vehicle": given["vehicle"], "aware": True, "live": True}
    pid: list[NodeSpec] = [NodeSpec("q2q_control", "pid", flown | promised)]
    radio: dict[str, ParameterValue] = {
        "crazyflies": given["crazyflies"],
        "mode": given["mode"],
        "vehicle": given["vehicle"],
    }
    return [
        NodeSpec("q2q_sim", "bag_record", {"bag": str(Path(given["folder"]) / "bag"), "stamps": "receive"}),
        NodeSpec("q2q_model", "mocap_filter", promised),
        NodeSpec("q2q_model", "interference", promised | {"model": given["model"]}),
        NodeSpec("q2q_planner", "trajectory", promised | {"plan": given["plan"]}),
        NodeSpec("q2q_planner", "replanner", promised),
        *(pid if by_stick else []),
        NodeSpec("q2q_control", "radio", radio),
        *_viewers(given),
    ]


def defaults(arguments: Sequence[Argument]) -> dict[str, str]:
    """Return every argument at its default."""
    return {one.name: one.default for one in arguments}


def _at_once(spec: NodeSpec) -> NodeSpec:
    """Let the simulator start by itself: no flight director waits for the nodes of a launch file."""
    if spec.executable != "simulator":
        return spec
    return NodeSpec(spec.package, spec.executable, {**spec.parameters, "autostart": True})


def _viewers(given: Mapping[str, str]) -> list[NodeSpec]:
    parameters: dict[str, ParameterValue] = {"foxglove": given["foxglove"] == YES}
    return [NodeSpec("q2q_sim", "view", parameters)] if given["view"] == YES else []


def _whole(text: str, name: str) -> int:
    try:
        return int(text)
    except ValueError as wrong:
        raise ValueError(f"{name}:={text}: a whole number is expected") from wrong
