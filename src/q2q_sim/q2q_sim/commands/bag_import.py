"""Convert a recorded flight to a bag: a table (Parquet, CSV), or micro-SD logs of Crazyflies."""

import sys
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path

from q2q_model.commands.argument_paths import require_existing
from q2q_model.commands.command_line import CommandLine, Work, run_command
from q2q_model.vehicle.constants import VEHICLES

EXAMPLE = """\
  ros2 run q2q_sim bag_import flight.parquet --vehicle crazyflie_2_1 --out flight
  ros2 run q2q_sim bag_import cf1_00 cf2_00 --out flight"""


def main(argv: Sequence[str] | None = None) -> int:
    """Convert the table of the command line; return the exit status."""
    return run_command(parser(), _prepare, argv)


def _prepare(args: Namespace) -> Work:
    require_existing("flight", *args.flight)
    require_existing("column map", args.columns)
    from q2q_sim.tools.import_table import run

    return run


def parser() -> CommandLine:
    """Return the parser of the command line."""
    made = CommandLine("bag_import", __doc__, EXAMPLE)
    made.add_argument(
        "flight",
        type=Path,
        nargs="+",
        help="one table (.parquet or .csv with columns t and <vehicle>_x ... or x ...), or one micro-SD log "
        "per vehicle",
    )
    made.add_argument(
        "--columns",
        type=Path,
        metavar="FILE",
        help="YAML file with the names and units of columns or log variables that differ",
    )
    made.add_argument(
        "--names",
        metavar="A,B",
        help="names of the logs' vehicles; default: file names up to the last _number",
    )
    made.add_argument(
        "--vehicle", default="", choices=tuple(VEHICLES), help="vehicle type, for the bag's metadata"
    )
    made.add_argument(
        "--out", type=Path, required=True, metavar="BAG", help="bag folder to write, which must not exist"
    )
    return made


if __name__ == "__main__":
    sys.exit(main())
