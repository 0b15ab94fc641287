"""Compare the emulated firmware with tables computed by the real one: `firmware_check FOLDER`.

The exit status is 1 if a difference exceeds its tolerance. FOLDER contains controllers.csv, planner.csv,
supervisor.csv, mixer.csv and compensation.csv, computed with the firmware's own C code.
"""

import sys
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path

from q2q_model.commands.argument_paths import require_existing
from q2q_model.commands.argument_types import add_printed_json
from q2q_model.commands.command_line import CommandLine, Work, run_command

EXAMPLE = """  ros2 run q2q_sim firmware_check ../shared/data/firmware
  ros2 run q2q_sim firmware_check ../shared/data/firmware --json"""
TABLES = ("controllers", "planner", "supervisor", "mixer", "compensation")


def main(argv: Sequence[str] | None = None) -> int:
    """Compare with the tables of the command line; return the exit status."""
    return run_command(parser(), _prepare, argv, refused=2)


def _prepare(args: Namespace) -> Work:
    require_existing("table", *(args.folder / f"{name}.csv" for name in TABLES))
    from q2q_sim.tools.check_firmware import run

    return run


def parser() -> CommandLine:
    """Return the parser of the command line."""
    made = CommandLine("firmware_check", __doc__, EXAMPLE)
    made.add_argument("folder", type=Path, metavar="FOLDER", help="folder with the five tables")
    add_printed_json(made, "print JSON instead, or write it to FILE")
    return made


if __name__ == "__main__":
    sys.exit(main())
