"""Recorded flights for the tools: bags, tables (Parquet, CSV) and folders of them."""

from collections.abc import Sequence
from pathlib import Path

from q2q_model.bag import TopicMap, is_bag
from q2q_model.flights.flight_and_log import Recording
from q2q_model.flights.table_file import TABLES
from q2q_model.identification.recording_files import flights_among, recording_of_table
from q2q_model.tools.bag_vehicle import FlownVehicle, common_vehicle
from q2q_model.tools.recordings import read_recordings


def read_flights(paths: Sequence[Path], topics: TopicMap | None = None) -> tuple[list[Recording], list[str]]:
    """Return the flights, bags first, and notes on repairs and on files left out.

    Raises:
        ValueError: a flight cannot be read, is given twice, or a folder has none.
    """
    found, notes = flights_among(paths)
    tables = [path for path in found if path.suffix in TABLES and path.is_file()]
    recordings, repairs = read_recordings([path for path in found if path not in tables], topics)
    recordings += [recording_of_table(path) for path in tables]
    names = [one.flight.name for one in recordings]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise ValueError(f"flight {', '.join(twice)} is given twice; give each flight once")
    return recordings, [*notes, *(f"repaired: {repair}" for repair in repairs)]


def vehicle_of(paths: Sequence[Path], override: str = "") -> FlownVehicle:
    """Return the common vehicle of the flights; `override` overrides it. Tables name none.

    Raises:
        ValueError: an unknown vehicle, or bags of different ones.
    """
    found = flights_among(paths)[0]
    return common_vehicle([path for path in found if is_bag(path)] or found, override)
