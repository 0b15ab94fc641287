"""Compare controllers in air models that were learned from other flights than their interaction models.

Writes a page with a plot and tables. The models are learned from the flights of the folder Q2Q_DATA
(docs/real_flights.md), unless the file --json contains them already, as docs/ablation.json does.
"""

import sys
from argparse import Namespace
from collections.abc import Sequence

from q2q_model.commands.argument_types import output_file, whole_number
from q2q_model.commands.command_line import CommandLine, Work, run_command
from q2q_sim.scenarios.choices import TABLE_ONLY

EXAMPLE = """  ros2 run q2q_sim ablation --json docs/ablation.json --out docs/ablation.md --jobs 2
  ros2 run q2q_sim ablation --draws 2 --only stack3 --airs ring --json out/stack3.json --out out/stack3.md"""


def main(argv: Sequence[str] | None = None) -> int:
    """Fly missing flights and write the page; return the exit status."""
    what = "interrupted; run the same command to resume from the numbers in --json"
    return run_command(parser(), _prepare, argv, interrupted=what)


def _prepare(_: Namespace) -> Work:
    from q2q_sim.experiments.ablation.fill_ablation import run

    return run


def parser() -> CommandLine:
    """Return the parser of the command line."""
    made = CommandLine("ablation", __doc__, EXAMPLE)
    made.add_argument(
        "--draws",
        type=whole_number(1, 5),
        default=4,
        metavar="N",
        help="number of random draws with each model, 1 to 5 (default 4)",
    )
    made.add_argument(
        "--json",
        type=output_file,
        required=True,
        metavar="FILE",
        help="file of results; flights that it contains are not repeated",
    )
    made.add_argument(
        "--out",
        type=output_file,
        required=True,
        metavar="FILE",
        help="page to write (.md); the plot is written next to it",
    )
    made.add_argument(
        "--jobs", type=whole_number(1), default=1, metavar="N", help="number of parallel flights (default 1)"
    )
    made.add_argument(
        TABLE_ONLY, action="store_true", help="write the page from the results in --json, without flying"
    )
    made.add_argument("--only", nargs="+", metavar="PATHS", help="fly only these paths (scenarios)")
    made.add_argument("--airs", nargs="+", metavar="AIR", help="fly only in these air models")
    made.add_argument("--controllers", nargs="+", metavar="NAME", help="fly only these controllers")
    return made


if __name__ == "__main__":
    sys.exit(main())
