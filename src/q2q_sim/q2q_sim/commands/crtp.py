"""Open a simulated room to CRTP clients without ROS: `crtp SCENARIO`.

Prints one URI for each vehicle, then flies at 100 Hz of wall time until interrupted.
"""

import sys
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path

from q2q_model.commands.argument_paths import require_existing
from q2q_model.commands.argument_types import whole_number
from q2q_model.commands.command_line import CommandLine, Work, run_command
from q2q_model.vehicle.thrust_map import FIRMWARES
from q2q_sim.scenarios import scenario_files


def main(argv: Sequence[str] | None = None) -> int:
    """Open the room of the command line; return the exit status."""
    return run_command(parser(), _prepare, argv)


def _prepare(args: Namespace) -> Work:
    scenario_files.check(args.scenario)
    require_existing("app", args.app)
    from q2q_sim.tools.fly_crtp_room import run

    return run


def parser() -> CommandLine:
    """Return the parser of the command line."""
    made = CommandLine("crtp", __doc__, "  ros2 run q2q_sim crtp table6 --start air")
    made.add_argument("scenario", nargs="?", default="table6", help="scenario name or YAML file")
    made.add_argument(
        "--port", type=whole_number(0, 65535), default=19850, help="first UDP port; 0 lets the system choose"
    )
    made.add_argument(
        "--start",
        default="ground",
        choices=("ground", "air"),
        help="on the ground below the first waypoint (default), or in the air at it",
    )
    made.add_argument(
        "--positioning",
        default="deck",
        choices=("deck", "flow", "external"),
        help="source of the vehicles' positions: a positioning deck (default), optical flow, or clients",
    )
    made.add_argument(
        "--zero-expires",
        action="store_true",
        help="let setpoints of zero thrust expire after 0.5 s; the real firmware keeps them",
    )
    made.add_argument(
        "--app",
        type=Path,
        metavar="DIR",
        help="folder written by export_app, whose app runs in the simulated firmware",
    )
    made.add_argument(
        "--firmware",
        default="",
        choices=FIRMWARES,
        help="firmware, which determines thrust per PWM (default: the scenario's)",
    )
    made.add_argument("--latency", type=float, default=0.0, help="latency of the link in each direction [s]")
    made.add_argument("--loss", type=float, default=0.0, help="fraction of packet transmissions lost")
    made.add_argument("--rate", type=float, default=0.0, help="packet rate of one radio [1/s]; 0 is no limit")
    made.add_argument("--seed", type=whole_number(0), default=0, help="random seed")
    return made


if __name__ == "__main__":
    sys.exit(main())
