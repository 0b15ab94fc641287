"""Firmware app from the command line."""

from argparse import Namespace

from q2q_control.onboard.app_folder import write_app
from q2q_model.model_files.find_model import find_model
from q2q_model.vehicle.constants import vehicle_by_name


def run(args: Namespace) -> int:
    """Write the app; print its files; return the exit status."""
    vehicle = vehicle_by_name(args.vehicle, args.firmware)
    for path in write_app(args.out, find_model(args.model), vehicle):
        print(path)
    return 0
