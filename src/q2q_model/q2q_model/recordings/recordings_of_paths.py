"""Recordings of many files: bags, tables (Parquet, CSV) and folders of them, each flight once."""

from collections.abc import Sequence
from pathlib import Path

from q2q_model.bag import TopicMap
from q2q_model.flights.tables.table_file import TABLES
from q2q_model.recordings.distinct_flights import distinct_flights, reject_duplicates
from q2q_model.recordings.flight_recording import Recording
from q2q_model.recordings.recording_reader import flights_among, recording_of_table
from q2q_model.recordings.recordings_of_bags import recordings_of_bags


def recordings_of_paths(
    paths: Sequence[Path], topics: TopicMap | None = None
) -> tuple[list[Recording], list[str]]:
    """Return the flights, bags first, and notes on repairs and on files left out.

    Flights are named by their folders or files, and by parent folders too where names collide.

    Raises:
        ValueError: a flight cannot be read, is given twice, also as a bag and a table, or a folder has none;
            or there are topics to map and no bags.
    """
    found, notes = flights_among(paths)
    reject_duplicates(found)
    tables = [path for path in found if path.suffix in TABLES and path.is_file()]
    if topics is not None and len(tables) == len(found):
        raise ValueError(f"--topics applies to bags, but {tables[0]} is a table: leave out --topics")
    bags = [path for path in found if path not in tables]
    recordings, repairs = recordings_of_bags(bags, topics)
    recordings += [recording_of_table(path) for path in tables]
    return distinct_flights([*bags, *tables], recordings), [
        *notes,
        *(f"repaired: {repair}" for repair in repairs),
    ]
