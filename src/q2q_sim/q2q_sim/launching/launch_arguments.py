"""Arguments of the launch files: strings, as from `ros2 launch`."""

from collections.abc import Collection
from dataclasses import dataclass, replace

from q2q_control.pid.gains_file import TUNED
from q2q_model.vehicle.constants import DEFAULT_VEHICLE, VEHICLES
from q2q_model.vehicle.thrust_map import FIRMWARES, STOCK
from q2q_sim.scenarios.choices import REPLANNERS

YES, NO = "true", "false"


@dataclass(frozen=True, slots=True)
class Argument:
    """One argument of a launch file."""

    name: str
    default: str
    description: str
    choices: tuple[str, ...] = ()


FOLDER = Argument(
    "folder",
    "",
    "folder to write parameters, plan and bag to; empty: a new one in out/launch/, named by the time",
)
VIEW = Argument("view", YES, "publish the flight as `scene` for RViz", (YES, NO))
FOXGLOVE = Argument("foxglove", NO, "with view: also serve the scene to Foxglove on this machine", (YES, NO))
AWARE = Argument("aware", YES, "compensate the predicted downwash", (YES, NO))
FIRMWARE = Argument("firmware", STOCK, "firmware of the vehicles, which determines thrust per PWM", FIRMWARES)
REPLAN = Argument(
    "replan",
    REPLANNERS[0],
    "online replanner: none, the paper's potential field, or the safe replanner",
    REPLANNERS,
)
MODEL = Argument("model", "", "interaction model of the controller: none, a shipped name, or a .q2q file")
ROOM_MODEL = replace(MODEL, default="measured_law")
PLAN = Argument("plan", "", "plan file to fly, made by `ros2 run q2q_planner plan`")
CRAZYFLIES = Argument("crazyflies", "", "crazyflies.yaml of Crazyswarm2")

SCENARIO_ARGUMENTS = (
    Argument("scenario", "table6", "scenario name or file; `scripts/fly --list` names them"),
    Argument(
        "mode",
        "aware",
        "compensate the downwash (aware; aware_unlimited: without the thrust limit), or not (ignoring)",
        ("aware", "aware_unlimited", "ignoring"),
    ),
    Argument("controller", "pid", "controller: pid, mpc, or module:Class of your own"),
    Argument(
        "pace",
        "live",
        "live: 100 Hz of wall time; lockstep: as fast as commands arrive",
        ("live", "lockstep"),
    ),
    Argument("seed", "0", "random seed"),
    MODEL,
    FOLDER,
    VIEW,
    FOXGLOVE,
)

ROOM_ARGUMENTS = (
    PLAN,
    CRAZYFLIES,
    Argument(
        "mode",
        "command",
        "setpoints sent to the vehicles: attitude and thrust (command), or full states (setpoint)",
        ("command", "setpoint"),
    ),
    Argument("vehicle", DEFAULT_VEHICLE, "vehicle type", tuple(VEHICLES)),
    FIRMWARE,
    Argument(
        "gains",
        TUNED,
        "with mode:=command: gains of the PID: tuned, firmware, mellinger, learned, or a file",
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
    Argument(
        "vehicle",
        "",
        f"vehicle type; empty: with twin, that of the scenario, else {DEFAULT_VEHICLE}",
        ("", *VEHICLES),
    ),
    Argument(
        "firmware",
        "",
        f"firmware, which determines thrust per PWM; empty: with twin, the scenario's, else {STOCK}",
        ("", *FIRMWARES),
    ),
    Argument("backend", "cpp", "backend of Crazyswarm2's server", ("cpp", "cflib")),
    Argument(
        "poses_version",
        "1",
        "message type of the poses, if motion_capture is empty: 1 is NamedPoseArray, 2 NamedPoseArrayV2",
        ("1", "2"),
    ),
    Argument(
        "motion_capture",
        "",
        "motion_capture.yaml for server and bridge, in place of the one installed with Crazyswarm2",
    ),
    AWARE,
    REPLAN,
    Argument("twin", NO, "fly the simulator in place of radios and room", (YES, NO)),
    Argument("scenario", "table6", "with twin: scenario of the simulator, with its vehicles and its air"),
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
