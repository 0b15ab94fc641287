"""Turn a recorded flight in a table (Parquet or CSV) into a bag: `ros2 run q2q_sim bag_import`."""

import sys
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path

from q2q_model.commands.command_line import CommandLine, Work, carry_out, must_exist


def main(words: Sequence[str] | None = None) -> int:
    """Convert as the command line says; return the exit status."""
    return carry_out(parser(), _prepare, words)


def _prepare(asked: Namespace) -> Work:
    must_exist("table", asked.table)
    from q2q_sim.tools.import_table import run

    return run


def parser() -> CommandLine:
    """Return the parser of the command line."""
    made = CommandLine("bag_import", __doc__, "  ros2 run q2q_sim bag_import flight.parquet --out flight")
    made.add_argument("table", type=Path, help="flight as .parquet or .csv: t, then <vehicle>_x ... or x ...")
    made.add_argument(
        "--out", type=Path, required=True, metavar="BAG", help="folder to write; must not exist"
    )
    return made


if __name__ == "__main__":
    sys.exit(main())
