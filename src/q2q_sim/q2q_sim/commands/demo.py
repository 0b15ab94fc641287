"""Fly one Crazyflie over another three times: ignoring the downwash, aware of it, aware without the limit.

The flight is that of the paper's sections 5.1 and 5.2 (scenario table6): Q1 hovers at 1.5 m, Q2 passes 0.5 m
above it. The table has the values of the paper's Table 6 for comparison. The last line is the verdict on each
flight; the exit status is 1 if one is not ok. Ignoring the downwash, Q1 sags without contact, which is ok.
"""

import sys
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path

from q2q_model.commands.command_line import CommandLine, Work, run_command


def main(argv: Sequence[str] | None = None) -> int:
    """Fly the demonstration; return the exit status."""
    return run_command(parser(), _prepare, argv, interrupted="interrupted; all nodes are ended")


def _prepare(_: Namespace) -> Work:
    from q2q_sim.processes.warm_start import begin

    print("demo: three flights: starting", file=sys.stderr, flush=True)
    begin()  # it imports in parallel
    from q2q_sim.tools.demo_flights import run

    return run


def parser() -> CommandLine:
    """Return the parser of the command line."""
    made = CommandLine("demo", __doc__, "  scripts/demo --json out.json")
    made.add_argument("--out", type=Path, default=Path("out/demo"), help="output folder")
    made.add_argument("--json", type=Path, help="write the numbers to this file")
    return made


if __name__ == "__main__":
    sys.exit(main())
