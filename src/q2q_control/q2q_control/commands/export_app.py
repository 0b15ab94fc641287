"""Write a firmware app in C99 that compensates the downwash of a model file on board a Crazyflie.

The app predicts the downwash of the nearest five vehicles from their broadcasts, corrects it by the vehicle's
accelerometer at 500 Hz, and subtracts it from the acceleration setpoint of the Mellinger controller. The
model must be a jet. DIR must be new or empty.
"""

import sys
from argparse import Namespace
from collections.abc import Sequence

from q2q_model.commands.argument_types import output_folder
from q2q_model.commands.command_line import CommandLine, Work, run_command
from q2q_model.model_files.model_names import check_model_name
from q2q_model.vehicle.constants import VEHICLES, vehicle_by_name
from q2q_model.vehicle.thrust_map import FIRMWARES, STOCK

EXAMPLE = """  ros2 run q2q_control export_app --model measured_law --out app/
  ros2 run q2q_control export_app --model model.q2q --out app/ --vehicle crazyflie_2_1"""


def main(argv: Sequence[str] | None = None) -> int:
    """Export the app of the command line; return the exit status."""
    return run_command(parser(), _prepare, argv)


def _prepare(args: Namespace) -> Work:
    vehicle_by_name(args.vehicle, args.firmware)
    check_model_name(args.model)
    from q2q_control.tools.write_firmware_app import run

    return run


def parser() -> CommandLine:
    """Return the parser of the command line."""
    made = CommandLine("export_app", __doc__, EXAMPLE)
    made.add_argument(
        "--model", required=True, help="interaction model: a shipped name, or a .q2q file with a jet"
    )
    made.add_argument(
        "--out", type=output_folder, required=True, metavar="DIR", help="folder to write the app to"
    )
    made.add_argument(
        "--vehicle", default="crazyflie_2_0", help=f"vehicle type: one of {', '.join(VEHICLES)}"
    )
    made.add_argument(
        "--firmware",
        default=STOCK,
        choices=FIRMWARES,
        help="firmware of the vehicle, which determines thrust per PWM",
    )
    return made


if __name__ == "__main__":
    sys.exit(main())
