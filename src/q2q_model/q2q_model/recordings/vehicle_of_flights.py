"""Vehicle of flights in bags, tables and folders of them."""

from collections.abc import Sequence
from pathlib import Path

from q2q_model.bag import is_bag
from q2q_model.recordings.bag_vehicle import FlownVehicle, common_vehicle
from q2q_model.recordings.recording_reader import flights_among


def vehicle_of_flights(paths: Sequence[Path], override: str = "") -> FlownVehicle:
    """Return the common vehicle of the flights; `override` overrides it. Tables name none.

    Raises:
        ValueError: an unknown vehicle, or bags of different ones.
    """
    found = flights_among(paths)[0]
    return common_vehicle([path for path in found if is_bag(path)] or found, override)
