"""Recordings of many bags, each flight once, with the repairs that reading took."""

import warnings
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from q2q_model.bag import (
    BagRepairWarning,
    TopicMap,
    is_bag,
    load_topic_map,
)
from q2q_model.forked import forked
from q2q_model.recordings.distinct_flights import distinct_flights, reject_duplicates
from q2q_model.recordings.flight_recording import Recording
from q2q_model.recordings.recording_reader import recording_of_bag


def recordings_of_bags(
    bags: Sequence[Path], topics: TopicMap | None = None
) -> tuple[list[Recording], list[str]]:
    """Return the flights in bags, and the repairs that reading took.

    Flights are named by their folders, and by parent folders too where names collide. `topics` maps the
    topics of bags of other software. Half of the bags are read by a second process.

    Raises:
        BagError: a bag cannot be read, or is given twice, also as a copy or by its file: a held-out flight
            would be in the fit.
    """
    reject_duplicates(bags)
    middle = (len(bags) + 1) // 2
    beside = forked(partial(_read, bags[middle:], topics))
    parts = [_read(bags[:middle], topics), beside()]
    recordings = [one for found, _ in parts for one in found]
    return distinct_flights(bags, recordings), [repair for _, repairs in parts for repair in repairs]


def _read(bags: Sequence[Path], topics: TopicMap | None) -> tuple[list[Recording], list[str]]:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", BagRepairWarning)
        recordings = [recording_of_bag(bag, topics) for bag in bags]
    return recordings, [str(one.message) for one in caught if issubclass(one.category, BagRepairWarning)]


def bags_among(paths: Sequence[Path]) -> tuple[list[Path], list[str]]:
    """Return the bags among paths, and a note on each other path: a glob also matches files next to bags.

    Missing paths are returned, and so are all if none is a bag, for the reader to reject.
    """
    others = [path for path in paths if path.exists() and not is_bag(path)]
    if len(others) == len(paths):
        return list(paths), []
    kept = [path for path in paths if path not in others]
    return kept, [f"skipped: {path} is not a bag" for path in others]


def topic_map(path: Path | None) -> TopicMap | None:
    """Return the map in a file; None for none."""
    return None if path is None else load_topic_map(path)
