"""Score an interaction model against the downwash measured on recorded flights.

The scoring rule is that of q2q_model.identification.push.push_samples. A flight without measured downwash
(neither a log of forces nor accelerometer and thrust commands) is named; its scores are null with n = 0.

R2 is not centred. The downwash on exposed rows is nearly constant, and on the recorded real flights a
constant alone reaches R2 0.60 (feed-forward off) and 0.48 (on): compare with that constant, not with 0. With
the neighbour's log shifted by 7 to 23 s, a law reaches R2 0.0 to 0.2 on the same rows, less than a constant
does, and less than 0 over all usable rows. "20 ms ahead" is R2 of the model corrected by the residual
that was known 20 ms before.
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
    made.add_argument("--model", required=True, help="none, a shipped name, or a .q2q file")
    made.add_argument("--json", type=output_file, metavar="FILE", help="file to write the scores to")
    add_recording_options(made)
    return made


if __name__ == "__main__":
    sys.exit(main())
