"""Plan minimum-snap trajectories that keep vehicles out of each other's downwash, proven for every time t."""

import argparse
import sys
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path

from q2q_model.commands.argument_paths import require_apart, require_existing
from q2q_model.commands.argument_types import (
    add_printed_json,
    finite_number,
    output_file,
    output_folder,
    positive_number,
)
from q2q_model.commands.command_line import CommandLine, UsageError, Work, run_command
from q2q_model.model_files.model_names import check_model_name
from q2q_model.vehicle.attitude_limits import TILT_MAX
from q2q_model.vehicle.constants import DEFAULT_VEHICLE, VEHICLES, vehicle_by_name

EXAMPLE = """  ros2 run q2q_planner plan waypoints.yaml --out plan.json
  ros2 run q2q_planner plan waypoints.yaml --out plan.json --model model.q2q --json cost.json --csv plan.csv
  ros2 run q2q_planner plan waypoints.yaml --out plan.json --model model.q2q --cut 0.88
  ros2 run q2q_planner plan waypoints.yaml --out plan.json --risk 0.01 --tube 0.08 0.06
  ros2 run q2q_planner plan waypoints.yaml --out plan.json --within -1.5 -1.5 0.2 1.5 1.5 2.6
  ros2 run q2q_planner plan waypoints.yaml --out plan.json --no-avoid --upload uploads/

waypoints.yaml:
  vehicles: {cf1: [{t: 0, pos: [-1, 0, 0]}, {t: 20, pos: [0, 0, 2.5]}, {t: 50, pos: [1, 0, 0]}], cf2: [..]}"""


def main(argv: Sequence[str] | None = None) -> int:
    """Plan from the command line; return the exit status."""
    return run_command(parser(), _prepare, argv)


def _prepare(args: Namespace) -> Work:
    if args.vehicle:
        vehicle_by_name(args.vehicle)
    if args.model:
        check_model_name(args.model)
    if args.warm_start and not args.avoid:
        raise UsageError("--warm-start starts the avoidance that --no-avoid omits: give one of them")
    require_existing("waypoint file", args.waypoints)
    require_existing("plan", args.warm_start)
    written = {"--out": args.out, "--json": args.json, "--csv": args.csv}
    folders = {"--upload": args.upload, "--figures": args.figures}
    require_apart({"the waypoint file": args.waypoints, "--warm-start": args.warm_start} | written, folders)
    from q2q_planner.tools.plan_swarm import run

    return run


def parser() -> CommandLine:
    """Return the parser of the command line."""
    made = CommandLine("plan", __doc__, EXAMPLE)
    made.add_argument("waypoints", type=Path, help="YAML file of waypoints")
    made.add_argument("--out", type=output_file, required=True, metavar="PLAN", help="plan file to write")
    add_printed_json(
        made, "print cost and proof as JSON (other text then goes to standard error), or write them to FILE"
    )
    made.add_argument(
        "--avoid",
        action=argparse.BooleanOptionalAction,
        default=True,
        help="change trajectories to keep vehicles out of each other's zone (default)",
    )
    made.add_argument(
        "--within",
        type=finite_number,
        nargs=6,
        metavar=("X", "Y", "Z", "FAR_X", "FAR_Y", "FAR_Z"),
        help="box that all vehicles stay within, proven for every t: smallest and largest x, y, z [m]",
    )
    made.add_argument(
        "--initial-guesses", type=int, default=2, help="number of initial guesses of the search (default 2)"
    )
    made.add_argument("--warm-start", type=Path, metavar="PLAN", help="start the search from this plan")
    made.add_argument(
        "--reading",
        choices=("stop_and_go", "free"),
        help="stop at every waypoint (stop_and_go), or pass through (free); in place of the file's (default "
        "stop_and_go)",
    )
    _add_further_files(made)
    _add_zone(made)
    _add_risk(made)
    _add_limits(made)
    return made


def _add_further_files(made: CommandLine) -> None:
    made.add_argument("--csv", type=output_file, help="write setpoints at 100 Hz to this file")
    made.add_argument(
        "--upload",
        type=output_folder,
        help="write a file <name>.csv per vehicle into this folder, for Crazyswarm2's trajectory upload",
    )
    made.add_argument(
        "--figures",
        type=output_folder,
        help="write figures of the plan (the paper's Figs 10 to 13) and a 3-D view with the zone into this "
        "folder",
    )


def _add_zone(made: CommandLine) -> None:
    zone = made.add_argument_group("zone")
    zone.add_argument(
        "--shape", choices=("cylinder", "ellipsoid"), help="shape of the zone (default: cylinder)"
    )
    zone.add_argument("--eps", type=float, help="radius of the zone [m] (default 0.1)")
    zone.add_argument("--d", type=float, help="half height of the zone [m] (default 1.1)")
    zone.add_argument(
        "--model",
        help="use the zone of this interaction model, a shipped name or a .q2q file, in place of --eps and "
        "--d",
    )
    zone.add_argument(
        "--threshold",
        type=positive_number,
        help="with --model: the zone is where the downwash exceeds this [m/s^2]",
    )
    zone.add_argument(
        "--cut",
        type=float,
        help="with --model: the zone is large enough to avoid this fraction of the height error",
    )


def _add_risk(made: CommandLine) -> None:
    risk = made.add_argument_group("risk, in place of a zone")
    risk.add_argument(
        "--risk",
        type=float,
        metavar="ALPHA",
        help="zone such that, with a probability of at most ALPHA in a flight, a vehicle leaves its tube or "
        "meets "
        "downwash beyond its thrust margin (downwash by --model, default measured_law)",
    )
    risk.add_argument(
        "--tube",
        type=float,
        nargs=2,
        metavar=("HORIZONTAL", "VERTICAL"),
        help="largest tracking error in a flight, horizontal and vertical [m]",
    )
    risk.add_argument(
        "--tube-risk", type=float, help="probability that a vehicle leaves its tube (default ALPHA / 2)"
    )
    risk.add_argument(
        "--hold",
        type=float,
        help="downwash that the thrust can carry [m/s^2] (default: the thrust margin minus 1 m/s^2)",
    )
    risk.add_argument(
        "--touch", type=float, help="distance between centres at which two vehicles touch [m] (default 0.14)"
    )


def _add_limits(made: CommandLine) -> None:
    limits = made.add_argument_group(
        "limits, used to compute the times of waypoints without t; a path around a zone may exceed "
        "speed and acceleration"
    )
    limits.add_argument(
        "--vehicle",
        help=f"vehicle type, in place of the file's ({DEFAULT_VEHICLE} if it names none): one of "
        f"{', '.join(VEHICLES)}",
    )
    limits.add_argument("--speed", type=float, default=2.0, help="largest speed [m/s]")
    limits.add_argument("--acceleration", type=float, default=2.0, help="largest acceleration [m/s^2]")
    limits.add_argument(
        "--tilt",
        type=float,
        default=TILT_MAX,
        help="largest tilt of the thrust [rad], also checked for waypoints with t; as `tilt_max` of the "
        "controllers "
        "(default 0.35)",
    )


if __name__ == "__main__":
    sys.exit(main())
