"""Fly one quadcopter over another three times, and compare the errors.

The controller ignores the downwash in the first flight, compensates it in the second, and compensates it
without the thrust limit in the third.

The flight is that of the paper's sections 5.1 and 5.2 (scenario table6): cf1 (the paper's Q1) hovers at 1.5
m, cf2 (Q2) passes 0.5 m above it. The table has the values of the paper's Table 6 for comparison. The last
line is the verdict on each flight; the exit status is 1 if one is not ok. Without compensation cf1 sinks, but
does not touch anything, which counts as ok.

With --real a model is fitted to recorded flights, scored on flights left out of the fit, and flown with an
air model learned from other real flights.
"""

import sys
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path

from q2q_model.commands.argument_paths import require_existing
from q2q_model.commands.argument_types import output_file, output_folder
from q2q_model.commands.command_line import CommandLine, Work, run_command

EXAMPLE = """  scripts/demo --json out.json
  scripts/demo --real --out out/real_demo"""


def main(argv: Sequence[str] | None = None) -> int:
    """Fly the demonstration; return the exit status."""
    return run_command(parser(), _prepare, argv, interrupted="interrupted; all nodes are ended")


def _prepare(args: Namespace) -> Work:
    require_existing("flight", *(args.real or []))
    from q2q_sim.processes.fork_server import start_fork_server

    start_fork_server()  # it imports in parallel
    if args.real is not None:
        from q2q_sim.tools.demo import real_flight

        return real_flight.run
    print("demo: three flights: starting", file=sys.stderr, flush=True)
    from q2q_sim.tools.demo import demo_flights

    return demo_flights.run


def parser() -> CommandLine:
    """Return the parser of the command line."""
    made = CommandLine("demo", __doc__, EXAMPLE)
    made.add_argument(
        "--real",
        nargs="*",
        type=Path,
        metavar="FLIGHT",
        help="use recorded flights: bags, tables (.parquet, .csv) or folders of them; without a value, those "
        "of "
        "the folder Q2Q_DATA, or the simulated ones in bags/",
    )
    made.add_argument("--out", type=output_folder, default=Path("out/demo"), help="output folder")
    made.add_argument("--json", type=output_file, help="write the metrics to this file")
    return made


if __name__ == "__main__":
    sys.exit(main())
