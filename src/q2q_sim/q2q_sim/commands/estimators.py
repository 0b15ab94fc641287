"""Replay recorded flights through the mocap filter and the firmware's estimator, and compare their errors.

Both get motion capture in four conditions: complete, at 10 Hz, with 30 % of the samples lost, and without 1 s
in every 4 s. Estimates are compared with samples that the estimators did not get. Give flights of one
vehicle.
"""

import sys
from argparse import Namespace
from collections.abc import Sequence

from q2q_model.commands.argument_paths import require_existing
from q2q_model.commands.argument_types import output_file, whole_number
from q2q_model.commands.command_line import CommandLine, Work, run_command
from q2q_model.commands.recording_options import add_recordings

EXAMPLE = "  ros2 run q2q_sim estimators flights/ --draws 3 --json out/estimators.json"


def main(argv: Sequence[str] | None = None) -> int:
    """Replay the flights of the command line; return the exit status."""
    return run_command(parser(), _prepare, argv)


def _prepare(args: Namespace) -> Work:
    require_existing("flight", *args.flights)
    return _run


def _run(args: Namespace) -> int:
    from q2q_model.recordings.recordings_of_paths import recordings_of_paths
    from q2q_sim.experiments.estimators.replay_flights import replay_flights

    recordings, notes = recordings_of_paths(args.flights)
    for note in notes:
        print(f"estimators: {note}", file=sys.stderr)
    return replay_flights(recordings, args)


def parser() -> CommandLine:
    """Return the parser of the command line."""
    made = CommandLine("estimators", __doc__, EXAMPLE)
    add_recordings(made)
    made.add_argument(
        "--draws",
        type=whole_number(1),
        default=3,
        metavar="N",
        help="number of random draws of lost samples and sensor errors (default 3)",
    )
    made.add_argument("--each", action="store_true", help="print the medians of every flight as well")
    made.add_argument("--json", type=output_file, metavar="FILE", help="file to write the numbers to")
    return made


if __name__ == "__main__":
    sys.exit(main())
