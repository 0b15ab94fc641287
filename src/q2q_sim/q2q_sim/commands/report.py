"""Report any recorded flight as one HTML page: tracking, downwash, commands, separation, mocap quality.

`report BAG --compare OTHER` lays flights over each other, the first one as what the others differ from.
"""

import sys
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path

from q2q_model.commands.command_line import CommandLine, Work, carry_out, must_exist
from q2q_model.vehicle.constants import VEHICLES, vehicle_by_name


def main(words: Sequence[str] | None = None) -> int:
    """Write the report the command line asks for; return the exit status."""
    return carry_out(parser(), _prepare, words)


def _prepare(asked: Namespace) -> Work:
    if asked.vehicle:
        vehicle_by_name(asked.vehicle)
    must_exist("bag", asked.bag, *asked.compare)
    must_exist("topic map", *([asked.topics] if asked.topics else []))
    from q2q_sim.tools.report_bags import run

    return run


def parser() -> CommandLine:
    """Return the parser of the command line."""
    made = CommandLine("report", __doc__, "  ros2 run q2q_sim report out/demo/bags/aware")
    made.add_argument("bag", type=Path, help="bag folder of the flight")
    made.add_argument("--compare", type=Path, nargs="+", default=[], help="more flights to lay over it")
    made.add_argument(
        "--vehicle", default="", help=f"in place of what the bag says: one of {', '.join(VEHICLES)}"
    )
    made.add_argument("--topics", type=Path, metavar="MAP.yaml", help="topics of bags that are not q2q's")
    made.add_argument("--out", type=Path, default=Path("out/report"), help="folder of page and pictures")
    made.add_argument("--json", type=Path, help="write the numbers to this file")
    return made


if __name__ == "__main__":
    sys.exit(main())
