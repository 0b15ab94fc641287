"""Learn an air model for the simulator from recorded flights; it is not an interaction model for controllers.

Each value is printed with its 95 % interval, and with the number and location of the samples it was learned
from. Terms that the flights do not determine are omitted, and listed.
"""

import sys
from argparse import Namespace
from collections.abc import Sequence

from q2q_model.commands.argument_paths import require_existing
from q2q_model.commands.argument_types import output_file
from q2q_model.commands.command_line import CommandLine, Work, run_command
from q2q_model.commands.recording_options import add_recording_options, add_recordings

EXAMPLE = """  ros2 run q2q_sim learn_air flights/ --out room.air
  ros2 run q2q_sim learn_air bags/table2_* stack.parquet --out room.air --json room.json"""


def main(argv: Sequence[str] | None = None) -> int:
    """Learn the air; return the exit status."""
    return run_command(parser(), _prepare, argv)


def _prepare(args: Namespace) -> Work:
    require_existing("flight", *args.flights)
    require_existing("topic map", args.topics)
    if not args.out.resolve().parent.is_dir():
        raise ValueError(f"no folder {args.out.resolve().parent} to write {args.out.name} to")
    from q2q_sim.tools.learn_flights import run

    return run


def parser() -> CommandLine:
    """Return the parser of the command line."""
    made = CommandLine("learn_air", __doc__, EXAMPLE)
    add_recordings(made)
    made.add_argument(
        "--out", type=output_file, required=True, metavar="FILE", help="air model to write (.air)"
    )
    made.add_argument(
        "--json", type=output_file, metavar="FILE", help="file to write values, intervals and checks to"
    )
    add_recording_options(made)
    return made


if __name__ == "__main__":
    sys.exit(main())
