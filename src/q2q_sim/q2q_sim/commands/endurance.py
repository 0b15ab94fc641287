"""Fly many vehicles for long, and report whether memory, handles, threads, bag and clock stay flat.

In lockstep the flight is as fast as the machine allows; with --live it takes its time, and the clock is
compared with the wall clock as well. The exit status is 1 unless every quantity is flat.
"""

import sys
from argparse import Namespace
from collections.abc import Sequence

from q2q_model.commands.argument_types import finite_number, output_file, whole_number
from q2q_model.commands.command_line import CommandLine, Work, run_command

EXAMPLE = """  ros2 run q2q_sim endurance --minutes 60 --json out/endurance.json
  ros2 run q2q_sim endurance --minutes 5 --live"""
SHORTEST = 1.0
"""[min]"""


def main(argv: Sequence[str] | None = None) -> int:
    """Fly for the time of the command line; return the exit status."""
    return run_command(parser(), _prepare, argv, interrupted="interrupted; all nodes are ended")


def _prepare(args: Namespace) -> Work:
    if not args.minutes >= SHORTEST:
        raise ValueError(f"--minutes {args.minutes:g}: {SHORTEST:g} or more is allowed")
    from q2q_sim.processes.fork_server import start_fork_server

    start_fork_server()  # it imports in parallel
    from q2q_sim.experiments.endurance.fly_endurance import run

    return run


def parser() -> CommandLine:
    """Return the parser of the command line."""
    made = CommandLine("endurance", __doc__, EXAMPLE)
    made.add_argument(
        "--minutes", type=finite_number, default=60.0, metavar="M", help="duration of the flight (default 60)"
    )
    made.add_argument(
        "--vehicles", type=whole_number(1), default=10, metavar="N", help="number of vehicles (default 10)"
    )
    made.add_argument("--live", action="store_true", help="100 Hz of wall time, every node a process")
    made.add_argument("--json", type=output_file, metavar="FILE", help="file to write the numbers to")
    return made


if __name__ == "__main__":
    sys.exit(main())
