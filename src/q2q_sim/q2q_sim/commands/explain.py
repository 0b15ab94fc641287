"""Explain a simulated flight: which causes moved a vehicle away from its path, and by how much each.

The flight of the bag is flown again, then repeated with one cause after another removed: downwash, battery
and saturation, motion capture, latency, lost messages, control, wind. --score counts how often the known
cause of a simulated accident is named first.
"""

import sys
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path

from q2q_model.commands.argument_paths import require_existing
from q2q_model.commands.argument_types import output_file, output_folder, whole_number
from q2q_model.commands.command_line import CommandLine, UsageError, Work, given_options, run_command

EXAMPLE = """  ros2 run q2q_sim explain out/demo/bags/ignoring --out out/why --json out/why.json
  ros2 run q2q_sim explain --score 20 --json out/score.json"""
FEWEST_ORDERS = 4
"""Two pairs, each with its reverse."""

OF_BAG, OF_SCORE = ("--of", "--orders", "--draws", "--out"), ("--seed",)
"""Options of the explanation of one bag, and of the score."""


def main(argv: Sequence[str] | None = None) -> int:
    """Explain the bag of the command line; return the exit status."""
    return run_command(parser(), _prepare, argv)


def _prepare(args: Namespace) -> Work:
    if bool(args.bag) == bool(args.score):
        raise UsageError("give either a bag or --score N")
    _check_partners(args)
    if args.orders < FEWEST_ORDERS or args.orders % 2:
        raise ValueError(f"--orders {args.orders}; must be even and at least {FEWEST_ORDERS}")
    require_existing("bag", args.bag)
    for folder in filter(None, (args.out, args.json and args.json.parent)):
        folder.mkdir(parents=True, exist_ok=True)  # refused now, and not after minutes of flights
    from q2q_sim.experiments.explanation.explain_bag import explain_bag, score_explanations

    return explain_bag if args.bag else score_explanations


def _check_partners(args: Namespace) -> None:
    """Raise UsageError for an option that would change nothing, with or without --score."""
    partner, ignored = ("--score", OF_BAG) if args.score else ("a bag", OF_SCORE)
    for option in given_options(args):
        if option in ignored:
            raise UsageError(f"{option} has no effect with {partner}")


def parser() -> CommandLine:
    """Return the parser of the command line."""
    made = CommandLine("explain", __doc__, EXAMPLE)
    made.add_argument("bag", nargs="?", type=Path, metavar="BAG", help="bag of `fly` or `campaign`")
    made.add_argument(
        "--out", type=output_folder, metavar="FOLDER", help="folder to write the page and its figure to"
    )
    made.add_argument("--json", type=output_file, metavar="FILE", help="file to write the numbers to")
    made.add_argument(
        "--of",
        choices=("distance", "height"),
        default="distance",
        help="deviation to explain: distance from the setpoint (default), or height error",
    )
    made.add_argument(
        "--orders",
        type=whole_number(1),
        default=8,
        metavar="N",
        help=f"number of orders in which causes are removed, even, {FEWEST_ORDERS} or more (default 8)",
    )
    made.add_argument(
        "--draws",
        type=whole_number(1),
        default=3,
        metavar="N",
        help="number of random draws of noise, losses and gusts (default 3)",
    )
    _add_score(made)
    return made


def _add_score(made: CommandLine) -> None:
    """Add the options of the score."""
    made.add_argument(
        "--score",
        type=whole_number(1),
        metavar="N",
        help="explain N simulated accidents of known cause instead of a bag",
    )
    made.add_argument(
        "--seed",
        type=whole_number(0),
        default=0,
        metavar="N",
        help="with --score: first seed of the accidents (default 0)",
    )


if __name__ == "__main__":
    sys.exit(main())
