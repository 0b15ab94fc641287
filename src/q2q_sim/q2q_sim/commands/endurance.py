"""Fly many vehicles for a long time, and report whether memory, handles, threads, bag or clock drift.

By default the flight runs in lockstep, as fast as the machine allows. With --live it runs at wall time, and
the flight's clock is compared with the wall clock, too. The exit status is 1 unless every quantity stays
constant.
"""

import sys
from argparse import Namespace
from collections.abc import Sequence

from q2q_model.commands.argument_types import finite_number, output_file, whole_number
from q2q_model.commands.command_line import CommandLine, Work, run_command
from q2q_sim.scenarios.scenario_limits import LONGEST, MOST_VEHICLES

EXAMPLE = """  ros2 run q2q_sim endurance --minutes 60 --json out/endurance.json
  ros2 run q2q_sim endurance --minutes 5 --live"""
SHORTEST = 1.0
"""[min]"""


def main(argv: Sequence[str] | None = None) -> int:
    """Fly for the time of the command line; return the exit status."""
    return run_command(parser(), _prepare, argv, interrupted="interrupted; all nodes are ended")


def _prepare(args: Namespace) -> Work:
    longest = LONGEST / 60.0
    if not SHORTEST <= args.minutes <= longest:
        raise ValueError(f"--minutes {args.minutes:g}; must be in [{SHORTEST:g}, {longest:g}] min")
    from q2q_sim.processes.fork_server import start_fork_server

    start_fork_server()  # it imports in parallel
    from q2q_sim.experiments.endurance.fly_endurance import run

    return run


def parser() -> CommandLine:
    """Return the parser of the command line."""
    made = CommandLine("endurance", __doc__, EXAMPLE)
    made.add_argument(
        "--minutes",
        type=finite_number,
        default=60.0,
        metavar="M",
        help="duration of the flight [min] (default 60)",
    )
    made.add_argument(
        "--vehicles",
        type=whole_number(1, MOST_VEHICLES),
        default=10,
        metavar="N",
        help="number of vehicles (default 10)",
    )
    made.add_argument(
        "--live", action="store_true", help="fly at 100 Hz of wall time, with a process for each node"
    )
    made.add_argument("--json", type=output_file, metavar="FILE", help="file to write the numbers to")
    return made


if __name__ == "__main__":
    sys.exit(main())
