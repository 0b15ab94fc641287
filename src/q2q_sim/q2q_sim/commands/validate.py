"""Simulate recorded flights in an air model, and compare the height errors with the recorded ones.

Each flight is simulated along its recorded references, with its own control law, which is identified from its
thrust commands. Give flights that the air model was not learned from. The JSON has the same numbers as the
page: under another vehicle and in clear air, for each flight and for all together.
"""

import sys
from argparse import Namespace
from collections.abc import Sequence

from q2q_model.commands.argument_paths import require_existing
from q2q_model.commands.argument_types import output_file, output_folder, whole_number
from q2q_model.commands.command_line import CommandLine, Work, run_command
from q2q_model.commands.recording_options import add_recording_options, add_recordings
from q2q_sim.air.air_names import check_air

EXAMPLE = "  ros2 run q2q_sim validate --air room.air flight3 flight4 --json v.json --out page/"
FEWEST_DRAWS, MOST_DRAWS = 3, 200
"""Draws of a flight: a band needs three, and 200 take ten times as long as the default."""


def main(argv: Sequence[str] | None = None) -> int:
    """Validate the air of the command line; return the exit status."""
    return run_command(parser(), _prepare, argv)


def _prepare(args: Namespace) -> Work:
    check_air(args.air)
    require_existing("flight", *args.flights)
    require_existing("topic map", args.topics)
    return _run


def _run(args: Namespace) -> int:
    from q2q_model.recordings.recordings_of_bags import topic_map
    from q2q_model.recordings.recordings_of_paths import recordings_of_paths
    from q2q_model.recordings.vehicle_of_flights import vehicle_of_flights
    from q2q_sim.air.lookup.find_air import find_air
    from q2q_sim.experiments.validation.validate_flights import validate

    air = find_air(args.air)
    recordings, notes = recordings_of_paths(args.flights, topic_map(args.topics))
    flown = vehicle_of_flights(args.flights, args.vehicle)
    for note in [*notes, *filter(None, [flown.note])]:
        print(f"validate: {note}", file=sys.stderr)
    return validate(recordings, flown.vehicle, air, args)


def parser() -> CommandLine:
    """Return the parser of the command line."""
    made = CommandLine("validate", __doc__, EXAMPLE)
    add_recordings(made)
    made.add_argument(
        "--air", required=True, metavar="AIR", help="air model: a shipped name, a .air file or module:Class"
    )
    made.add_argument(
        "--draws",
        type=whole_number(FEWEST_DRAWS, MOST_DRAWS),
        default=20,
        metavar="N",
        help="number of random draws of each flight (default 20)",
    )
    made.add_argument("--json", type=output_file, metavar="FILE", help="file to write the numbers to")
    made.add_argument(
        "--out", type=output_folder, metavar="FOLDER", help="folder to write the page and its figures to"
    )
    add_recording_options(made)
    return made


if __name__ == "__main__":
    sys.exit(main())
