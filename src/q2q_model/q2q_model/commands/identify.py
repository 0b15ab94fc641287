"""Identify gains, interference zone and interaction model from recorded flights."""

import sys
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path

from q2q_model.commands.argument_paths import require_apart, require_existing
from q2q_model.commands.argument_types import output_file, positive_number
from q2q_model.commands.command_line import CommandLine, UsageError, Work, given_options, run_command
from q2q_model.commands.recording_options import add_recording_options
from q2q_model.model_files.model_names import check_model_name

EXAMPLE = """  ros2 run q2q_model identify bags/table2_* --out model.q2q --json report.json
  ros2 run q2q_model identify flight1 flight2 --out model.q2q --model-type jet
  ros2 run q2q_model identify room/* --topics room.yaml --out model.q2q
  ros2 run q2q_model identify --live --vehicle crazyflie_2_1 --model model.q2q --out refined.q2q"""


OF_LIVE = ("--model",)
OF_BAGS = ("--topics", "--json", "--threshold", "--model-type", "--no-plots")
"""Options without effect in the other mode."""
PARAMETERS = ("-p", "--param", "--params-file")
"""Words by which ROS sets the parameters of a node, which only --live runs."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run `identify`; return the exit status."""
    return run_command(parser(), _prepare, argv)


def _prepare(args: Namespace) -> Work:
    if bool(args.bags) == args.live:
        raise UsageError("give either bags of recorded flights, or --live")
    _refuse_other_mode(args)
    if args.live:
        check_model_name(args.model)
    require_existing("bag", *args.bags)
    require_existing("topic map", args.topics)
    _require_apart(args)
    from q2q_model.tools.identify_flights import run

    return run


def _refuse_other_mode(args: Namespace) -> None:
    """Raise UsageError for an option that is given and has no effect in this mode."""
    needs = "bags of recorded flights, not --live" if args.live else "--live, not bags of recorded flights"
    other = OF_BAGS if args.live else OF_LIVE
    if wrong := [option for option in given_options(args) if option in other]:
        raise UsageError(f"{wrong[0]} needs {needs}")
    if not args.live and (words := [word for word in PARAMETERS if word in args.ros_argv]):
        raise UsageError(f"--ros-args {words[0]} needs {needs}")


def _require_apart(args: Namespace) -> None:
    """Raise UsageError if model or report would be written over each other, the topic map or a bag."""
    report = "--json" if args.json else "the report next to it"
    written = {"--out": args.out, report: args.json or args.out.with_suffix(".json")}
    for bag in args.bags:
        require_apart({"a bag": bag, "--topics": args.topics} | written)


def parser() -> CommandLine:
    """Return the parser of the command line."""
    made = CommandLine("identify", __doc__, EXAMPLE)
    made.add_argument("bags", nargs="*", type=Path, metavar="BAG", help="recorded flights")
    made.add_argument(
        "--out", type=output_file, required=True, metavar="FILE", help="model file to write (.q2q)"
    )
    made.add_argument(
        "--json", type=output_file, metavar="FILE", help="report to write (default: next to the model file)"
    )
    made.add_argument(
        "--model-type",
        default="auto",
        choices=("auto", "jet", "envelope_network"),
        help="type of model; auto (default) selects the one with the smallest error on held-out flights",
    )
    add_recording_options(made)
    made.add_argument(
        "--threshold",
        type=positive_number,
        default=0.1,
        help="downwash at the edge of the identified zone [m/s^2] (default 0.1)",
    )
    made.add_argument(
        "--live",
        action="store_true",
        help="refine --model by the topics of a running flight, until interrupted",
    )
    made.add_argument("--model", default="paper_law", help="with --live: initial model (default paper_law)")
    made.add_argument("--no-plots", action="store_true", help="do not draw figures")
    return made


if __name__ == "__main__":
    sys.exit(main())
