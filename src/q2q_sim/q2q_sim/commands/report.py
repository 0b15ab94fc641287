"""Write an HTML page about a recorded flight: tracking, downwash, commands, separation, mocap quality.

`report BAG --compare OTHER` draws several flights in the same plots; BAG is the reference of the comparison.
"""

import sys
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path

from q2q_model.commands.argument_paths import require_existing
from q2q_model.commands.argument_types import output_file, output_folder
from q2q_model.commands.command_line import CommandLine, Work, run_command
from q2q_model.vehicle.constants import VEHICLES, vehicle_by_name


def main(argv: Sequence[str] | None = None) -> int:
    """Write the report of the command line; return the exit status."""
    return run_command(parser(), _prepare, argv)


def _prepare(args: Namespace) -> Work:
    if args.vehicle:
        vehicle_by_name(args.vehicle)
    require_existing("bag", args.bag, *args.compare)
    require_existing("topic map", args.topics)
    from q2q_sim.tools.report_bags import run

    return run


def parser() -> CommandLine:
    """Return the parser of the command line."""
    made = CommandLine("report", __doc__, "  ros2 run q2q_sim report out/demo/bags/aware")
    made.add_argument("bag", type=Path, help="bag folder of the flight")
    made.add_argument(
        "--compare", type=Path, nargs="+", default=[], help="bags of further flights, drawn in the same plots"
    )
    made.add_argument(
        "--vehicle", default="", help=f"vehicle type, in place of the bag's: one of {', '.join(VEHICLES)}"
    )
    made.add_argument(
        "--topics", type=Path, metavar="MAP.yaml", help="topic map of bags that q2q did not record"
    )
    made.add_argument(
        "--out", type=output_folder, default=Path("out/report"), help="folder to write page and figures to"
    )
    made.add_argument("--json", type=output_file, help="write the metrics to this file")
    return made


if __name__ == "__main__":
    sys.exit(main())
