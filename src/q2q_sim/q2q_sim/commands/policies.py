"""Check recorded flights against the safety policies: `policies BAG...`.

The exit status is 0 if no policy is violated, 1 if one is, and 2 if a bag cannot be read or contains nothing
that can be checked.
"""

import sys
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path

from q2q_model.commands.argument_paths import require_existing
from q2q_model.commands.command_line import CommandLine, Work, run_command
from q2q_model.vehicle.constants import VEHICLES, vehicle_by_name
from q2q_sim.scenarios import scenario_files

EXAMPLE = """  ros2 run q2q_sim policies bags/table2_1
  ros2 run q2q_sim policies out/campaign/violations/17 --scenario out/campaign/violations/17.yaml --json"""


def main(argv: Sequence[str] | None = None) -> int:
    """Check the bags of the command line; return the exit status."""
    return run_command(parser(), _prepare, argv, refused=2)


def _prepare(args: Namespace) -> Work:
    require_existing("bag", *args.bags)
    if args.scenario:
        scenario_files.check(args.scenario)
    if args.vehicle:
        vehicle_by_name(args.vehicle)
    from q2q_sim.tools.judge_bags import run

    return run


def parser() -> CommandLine:
    """Return the parser of the command line."""
    made = CommandLine("policies", __doc__, EXAMPLE)
    made.add_argument("bags", type=Path, nargs="+", metavar="BAG", help="bag folder of a flight")
    made.add_argument(
        "--scenario", default="", help="scenario whose injected faults are used in place of those in the bag"
    )
    made.add_argument(
        "--vehicle", default="", help=f"vehicle type, in place of the bag's: one of {', '.join(VEHICLES)}"
    )
    made.add_argument("--json", action="store_true", help="print the violations as JSON")
    return made


if __name__ == "__main__":
    sys.exit(main())
