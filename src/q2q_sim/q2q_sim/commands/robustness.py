"""Compare controllers that correct the predicted downwash with the same ones without any compensation.

Each controller (pid, mpc) flies with 12 wrong assumptions in each air model: among them a wrong interaction
model, a wrong latency, missing accelerometers, a neighbour that is not tracked, a weak battery, and thrust at
its limit for seconds.
"""

import sys
from argparse import Namespace
from collections.abc import Sequence

from q2q_model.commands.argument_types import output_file, whole_number
from q2q_model.commands.command_line import CommandLine, Work, run_command
from q2q_sim.air.air_names import RECORDED, ROOM, SYNTHETIC, check_air
from q2q_sim.scenarios.choices import TABLE_ONLY

MOST_DRAWS = 25
AIRS = (ROOM, RECORDED, *SYNTHETIC, "paper")
EXAMPLE = """  ros2 run q2q_sim robustness --json out/robustness.json --out docs/robustness.md
  ros2 run q2q_sim robustness --airs ring bent --draws 2 --json out/two.json --out out/two.md"""


def main(argv: Sequence[str] | None = None) -> int:
    """Fly missing flights and write the page; return the exit status."""
    what = "interrupted; run the same command to resume from the numbers in --json"
    return run_command(parser(), _prepare, argv, interrupted=what)


def _prepare(given: Namespace) -> Work:
    for air in given.airs:
        check_air(air)
    from q2q_sim.experiments.robustness.fill_robustness import run

    return run


def parser() -> CommandLine:
    """Return the parser of the command line."""
    made = CommandLine("robustness", __doc__, EXAMPLE)
    made.add_argument("--airs", nargs="+", default=list(AIRS), metavar="AIR", help="air models to fly in")
    made.add_argument(
        "--draws",
        type=whole_number(1, MOST_DRAWS),
        default=2,
        metavar="N",
        help="number of random draws of each flight, 1 to 25 (default 2)",
    )
    made.add_argument("--seed", type=whole_number(0), default=2001, metavar="N", help="seed of the flights")
    made.add_argument(
        "--json",
        type=output_file,
        required=True,
        metavar="FILE",
        help="file of results; flights that it contains are not repeated",
    )
    made.add_argument("--out", type=output_file, required=True, metavar="FILE", help="page to write (.md)")
    made.add_argument(
        TABLE_ONLY, action="store_true", help="write the page from the results in --json, without flying"
    )
    return made


if __name__ == "__main__":
    sys.exit(main())
