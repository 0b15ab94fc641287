"""Options of every command that reads recorded flights: their topics and their vehicle."""

from pathlib import Path

from q2q_model.commands.command_line import CommandLine
from q2q_model.vehicle.constants import VEHICLES


def add_recordings(parser: CommandLine) -> None:
    """Add `flights`, the recordings to read."""
    parser.add_argument(
        "flights",
        nargs="+",
        type=Path,
        metavar="FLIGHT",
        help="bag, table (.parquet, .csv), or a folder of bags and tables",
    )


def add_recording_options(parser: CommandLine) -> None:
    """Add `--topics` and `--vehicle`."""
    parser.add_argument(
        "--topics", type=Path, metavar="MAP.yaml", help="topic map of bags that q2q did not record"
    )
    parser.add_argument(
        "--vehicle",
        default="",
        choices=tuple(VEHICLES),
        help="vehicle type, in place of that named in the bags",
    )
