"""Write a page that replays flights in a browser: room, vehicles, downwash, motion capture, height curves.

The page is one HTML file that needs no network. Several flights are played side by side, at the same time.
What a flight did not record is omitted, and the page says so.
"""

import sys
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path

from q2q_model.commands.argument_paths import require_existing
from q2q_model.commands.argument_types import output_file
from q2q_model.commands.command_line import CommandLine, Work, run_command
from q2q_model.vehicle.constants import VEHICLES, vehicle_by_name

EXAMPLE = "  ros2 run q2q_sim replay_page out/demo/bags/ignoring out/demo/bags/aware --out replay.html"


def main(argv: Sequence[str] | None = None) -> int:
    """Write the page of the command line; return the exit status."""
    return run_command(parser(), _prepare, argv)


def _prepare(args: Namespace) -> Work:
    if args.vehicle:
        vehicle_by_name(args.vehicle)
    require_existing("flight", *args.flights)
    require_existing("topic map", args.topics)
    from q2q_sim.tools.write_replay import run

    return run


def parser() -> CommandLine:
    """Return the parser of the command line."""
    made = CommandLine("replay_page", __doc__, EXAMPLE)
    made.add_argument(
        "flights", nargs="+", type=Path, metavar="BAG", help="bags or tables (.parquet, .csv), up to three"
    )
    made.add_argument("--out", type=output_file, default=Path("out/replay.html"), help="file of the page")
    made.add_argument("--title", default="", help="title of the page; default: the flights' names")
    made.add_argument(
        "--start", type=float, default=0.0, metavar="S", help="start of the replay [s] (default 0)"
    )
    made.add_argument(
        "--end", type=float, metavar="S", help="end of the replay [s] (default: that of the flight)"
    )
    made.add_argument(
        "--vehicle", default="", help=f"vehicle type, in place of the bag's: one of {', '.join(VEHICLES)}"
    )
    made.add_argument(
        "--topics", type=Path, metavar="MAP.yaml", help="topic map of bags that q2q did not record"
    )
    return made


if __name__ == "__main__":
    sys.exit(main())
