"""Reproduce every table and figure of the paper with simulated flights, next to the paper's numbers.

Results of finished experiments are stored in OUT/cache, and used until the code changes. An interrupted run
resumes.
"""

import sys
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path

from q2q_model.commands.argument_types import add_printed_json, output_folder
from q2q_model.commands.command_line import CommandLine, Work, run_command

EXAMPLE = """  scripts/paper
  scripts/paper --only table6,fig10 --json out/paper.json"""


def main(argv: Sequence[str] | None = None) -> int:
    """Reproduce the paper; return the exit status."""
    what = "interrupted; run the same command to resume"
    return run_command(parser(), _prepare, argv, interrupted=what)


def _prepare(args: Namespace) -> Work:
    if args.only:
        from q2q_sim.experiments.paper.paper_numbers import paper_numbers, select_numbers

        select_numbers(paper_numbers(), args.only)
    from q2q_sim.experiments.paper.reproduction import run

    return run


def parser() -> CommandLine:
    """Return the parser of the command line."""
    made = CommandLine("paper", __doc__, EXAMPLE)
    made.add_argument(
        "--only", default="", metavar="LIST", help="only these tables and figures, for example table6,fig10"
    )
    made.add_argument(
        "--out",
        type=output_folder,
        default=Path("out/paper"),
        help="folder to write page, PDF and figures to",
    )
    add_printed_json(
        made, "print the rows as JSON (other text then goes to standard error), or write them to FILE"
    )
    made.add_argument("--again", action="store_true", help="run all experiments again, also finished ones")
    return made


if __name__ == "__main__":
    sys.exit(main())
