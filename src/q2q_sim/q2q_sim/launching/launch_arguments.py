"""Arguments of the launch files: strings, as from `ros2 launch`."""

from collections.abc import Collection
from dataclasses import dataclass, replace

from q2q_control.pid.gains_file import TUNED
from q2q_model.vehicle.constants import DEFAULT_VEHICLE, VEHICLES
from q2q_model.vehicle.thrust_map import FIRMWARES, STOCK
from q2q_sim.scenarios.choices import CONTROLLERS, REPLANNERS

YES, NO = "true", "false"


@dataclass(frozen=True, slots=True)
class Argument:
    """One argument of a launch file."""

    name: str
    default: str
    description: str
    choices: tuple[str, ...] = ()


FOLDER = Argument("folder", "", "output folder for parameters, plan and bag; empty: out/launch/ and the date")
VIEW = Argument("view", YES, "show the flight: `scene` for RViz", (YES, NO))
FOXGLOVE = Argument("foxglove", NO, "with view: Foxglove server on this machine", (YES, NO))
AWARE = Argument("aware", YES, "compensate the predicted downwash", (YES, NO))
FIRMWARE = Argument("firmware", STOCK, "firmware of the vehicles, which sets thrust per PWM", FIRMWARES)
REPLAN = Argument("replan", REPLANNERS[0], "law that moves setpoints out of zones online", REPLANNERS)
MODEL = Argument("model", "", "interaction model: none, a shipped name, or a .q2q file")
ROOM_MODEL = replace(MODEL, default="measured_law")
PLAN = Argument("plan", "", "plan file to fly, made by `ros2 run q2q_planner plan`")
CRAZYFLIES = Argument("crazyflies", "", "crazyflies.yaml of Crazyswarm2")

SCENARIO_ARGUMENTS = (
    Argument("scenario", "table6", "scenario name or file; `scripts/fly --list` names them"),
    Argument("mode", "aware", "compensate the downwash or not", ("aware", "aware_unlimited", "ignoring")),
    Argument("controller", "pid", "controller", CONTROLLERS),
    Argument("pace", "live", "100 Hz of wall time, or as fast as commands arrive", ("live", "lockstep")),
    Argument("seed", "0", "random seed"),
    MODEL,
    FOLDER,
    VIEW,
    FOXGLOVE,
)

ROOM_ARGUMENTS = (
    PLAN,
    CRAZYFLIES,
    Argument("mode", "command", "attitude and thrust, or full states", ("command", "setpoint")),
    Argument("vehicle", DEFAULT_VEHICLE, "vehicle constants", tuple(VEHICLES)),
    FIRMWARE,
    Argument(
        "gains",
        TUNED,
        "with mode:=command: tuned, firmware, mellinger, learned, or a file (docs/nodes/pid.md)",
    ),
    AWARE,
    REPLAN,
    Argument("mocap", "mocap", "topic of the motion capture (q2q_msgs/MocapFrame)"),
    ROOM_MODEL,
    FOLDER,
    VIEW,
    FOXGLOVE,
)

COMMON_ARGUMENTS = (
    Argument("namespace", "", "namespace of all nodes and topics"),
    Argument("use_sim_time", NO, "use /clock, as with a simulator", (YES, NO)),
)
"""Arguments of every launch file."""

CRAZYSWARM_ARGUMENTS = (
    PLAN,
    CRAZYFLIES,
    Argument("vehicle", "", f"vehicle constants; empty: the twin's, or {DEFAULT_VEHICLE}", ("", *VEHICLES)),
    Argument(
        "firmware", "", f"firmware, for thrust per PWM; empty: the twin's, or {STOCK}", ("", *FIRMWARES)
    ),
    Argument("backend", "cpp", "backend of Crazyswarm2's server", ("cpp", "cflib")),
    Argument(
        "poses_version", "1", "version of the poses without motion_capture: 2 is NamedPoseArrayV2", ("1", "2")
    ),
    Argument("motion_capture", "", "motion_capture.yaml of server and bridge, in place of poses_version"),
    AWARE,
    REPLAN,
    Argument("twin", NO, "simulator in place of radios and room", (YES, NO)),
    Argument("scenario", "table6", "with twin: scenario of the vehicles and the wake"),
    ROOM_MODEL,
    FOLDER,
    VIEW,
    FOXGLOVE,
)


def undeclared(given: Collection[str], declared: Collection[str]) -> str:
    """Return a warning of the arguments that a launch file does not have; empty if there are none."""
    others = sorted(set(given) - set(declared))
    words = (
        f"ignored: {', '.join(f'{name}:=' for name in others)}; arguments are {', '.join(sorted(declared))}"
    )
    return words if others else ""
