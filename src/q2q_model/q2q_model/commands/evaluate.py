"""Score an interaction model against the downwash measured on recorded flights.

The scores are defined in q2q_model.identification.push.push_samples. Flights in which the downwash cannot be
measured, because they have neither a log of forces nor accelerometer and thrust commands, are listed; their
scores are null with n = 0.

R2 is not centred: it compares the model with no downwash, not with the mean. In samples under another vehicle
the downwash is nearly constant, and on the recorded real flights a constant alone reaches R2 0.60
(feed-forward off) and 0.48 (on): compare a model with that constant, not with 0. If the neighbour's log is
shifted by 7 to 23 s, a model reaches R2 0.0 to 0.2 on the same samples, less than a constant, and less than 0
on all usable samples. "20 ms ahead" is R2 of the model corrected by its residual of 20 ms before.
"""

import sys
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path

from q2q_model.commands.argument_paths import require_apart, require_existing
from q2q_model.commands.argument_types import output_file
from q2q_model.commands.command_line import CommandLine, Work, run_command
from q2q_model.commands.recording_options import add_recording_options
from q2q_model.model_files.model_names import model_path

EXAMPLE = "  ros2 run q2q_model evaluate --model model.q2q flight1 flight2 --json scores.json"


def main(argv: Sequence[str] | None = None) -> int:
    """Run `evaluate`; return the exit status."""
    return run_command(parser(), _prepare, argv)


def _prepare(args: Namespace) -> Work:
    model = model_path(args.model)
    require_existing("bag", *args.bags)
    require_existing("topic map", args.topics)
    for bag in args.bags:
        require_apart({"--model": model, "--topics": args.topics, "a bag": bag, "--json": args.json})
    from q2q_model.tools.score_model import run

    return run


def parser() -> CommandLine:
    """Return the parser of the command line."""
    made = CommandLine("evaluate", __doc__, EXAMPLE)
    made.add_argument("bags", nargs="+", type=Path, metavar="BAG", help="recorded flights, at least one")
    made.add_argument(
        "--model", required=True, help="interaction model: none, a shipped name, or a .q2q file"
    )
    made.add_argument("--json", type=output_file, metavar="FILE", help="file to write the scores to")
    add_recording_options(made)
    return made


if __name__ == "__main__":
    sys.exit(main())
