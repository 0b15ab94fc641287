"""Test the separation guarantee of the safe replanner in random encounters with simulated dynamics.

Flight k is drawn from seed k: 2 to 10 Crazyflies on crossing paths, in an air model learned from real
flights, with delays and lost packets. --learn writes the tube of tracking errors of these flights, which a
new flight does not leave with probability 1 - alpha. --tube flies with such a tube, and counts the flights
that leave it. The exit status is 1 if a vehicle entered another's zone in a flight that began under the
conditions of the guarantee.
"""

import sys
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path

from q2q_model.commands.argument_paths import require_existing
from q2q_model.commands.argument_types import output_file, whole_number
from q2q_model.commands.command_line import CommandLine, Work, given_options, run_command
from q2q_sim.air.air_names import check_air
from q2q_sim.scenarios.choices import CONTROLLERS

EXAMPLE = """  ros2 run q2q_sim promise --count 400 --alpha 0.05 --learn out/tube.json
  ros2 run q2q_sim promise --first 1000 --count 400 --tube out/tube.json --json out/promise.json"""


def main(argv: Sequence[str] | None = None) -> int:
    """Fly the encounters of the command line; return the exit status."""
    return run_command(parser(), _prepare, argv)


def _prepare(args: Namespace) -> Work:
    if not 0.0 < args.alpha < 1.0:
        raise ValueError(f"--alpha {args.alpha:g}; must be above 0 and below 1")
    if "--alpha" in given_options(args) and not args.learn:
        raise ValueError(f"--alpha {args.alpha:g} applies to the tube that --learn FILE writes: give both")
    check_air(args.air)
    require_existing("tube", args.tube)
    from q2q_sim.experiments.promise.promise_flights import run

    return run


def parser() -> CommandLine:
    """Return the parser of the command line."""
    made = CommandLine("promise", __doc__, EXAMPLE)
    made.add_argument(
        "--count", type=whole_number(1), default=100, metavar="N", help="number of flights (default 100)"
    )
    made.add_argument(
        "--first",
        type=whole_number(0),
        default=0,
        metavar="SEED",
        help="seed of the first flight (default 0)",
    )
    made.add_argument(
        "--jobs",
        type=whole_number(1),
        default=1,
        metavar="N",
        help="number of parallel processes (default 1)",
    )
    made.add_argument("--controller", choices=CONTROLLERS, default="pid", help="controller (default pid)")
    made.add_argument(
        "--air",
        default="room",
        metavar="AIR",
        help="air model: a shipped name, a .air file or module:Class (default room)",
    )
    made.add_argument(
        "--jerk", type=float, metavar="J", help="largest jerk of a replanned setpoint [m/s^3]; 0: no limit"
    )
    _add_tube(made)
    made.add_argument(
        "--keep",
        type=output_file,
        metavar="FILE",
        help="store finished flights in this file, as JSON lines, and resume from it",
    )
    made.add_argument("--json", type=output_file, metavar="FILE", help="file to write the numbers to")
    return made


def _add_tube(made: CommandLine) -> None:
    """Add the options of the tube of tracking error."""
    made.add_argument(
        "--tube",
        type=Path,
        metavar="FILE",
        help="fly with the tube in this file, and count the flights that leave it",
    )
    made.add_argument(
        "--learn", type=output_file, metavar="FILE", help="write the tube of these flights to this file"
    )
    made.add_argument(
        "--alpha",
        type=float,
        default=0.05,
        metavar="A",
        help="with --learn: fraction of flights that may leave the tube (default 0.05)",
    )


if __name__ == "__main__":
    sys.exit(main())
