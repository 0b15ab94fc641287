"""Recordings of many bags, each flight once, with the repairs that reading took."""

import warnings
from collections.abc import Sequence
from dataclasses import fields, replace
from functools import partial
from pathlib import Path

import numpy as np

from q2q_model.bag import (
    BagError,
    BagRepairWarning,
    TopicMap,
    is_bag,
    load_topic_map,
)
from q2q_model.flights.flight import Flight
from q2q_model.forked import forked
from q2q_model.recordings.recorded_flight import Recording
from q2q_model.recordings.recording_files import recording_of_bag


def recordings_of_bags(
    bags: Sequence[Path], topics: TopicMap | None = None
) -> tuple[list[Recording], list[str]]:
    """Return the flights in bags, and the repairs that reading took.

    Flights are named by their folders, and by parent folders too where names collide. `topics` maps the
    topics of bags of other software. Half of the bags are read beside this process.

    Raises:
        BagError: a bag cannot be read, or is given twice, also as a copy or by its file: a held-out flight
            would be in the fit.
    """
    _reject_duplicates([bag.resolve() for bag in bags])
    middle = (len(bags) + 1) // 2
    beside = forked(partial(_read, bags[middle:], topics))
    parts = [_read(bags[:middle], topics), beside()]
    recordings = [one for found, _ in parts for one in found]
    _reject_copies(bags, recordings)
    names = [one.flight.name for one in recordings]
    for k, bag in enumerate(bags):
        alike = [other.resolve() for j, other in enumerate(bags) if j != k and names[j] == names[k]]
        if alike:
            flight = replace(recordings[k].flight, name=_distinct_end(bag.resolve(), alike))
            recordings[k] = replace(recordings[k], flight=flight)
    return recordings, [repair for _, repairs in parts for repair in repairs]


def _distinct_end(path: Path, others: Sequence[Path]) -> str:
    """Return the shortest end of a path, in whole parts, that none of other paths has."""
    sizes = range(1, len(path.parts) + 1)
    size = next(n for n in sizes if all(other.parts[-n:] != path.parts[-n:] for other in others))
    return "/".join(path.parts[-size:])


def _read(bags: Sequence[Path], topics: TopicMap | None) -> tuple[list[Recording], list[str]]:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", BagRepairWarning)
        recordings = [recording_of_bag(bag, topics) for bag in bags]
    return recordings, [str(one.message) for one in caught if issubclass(one.category, BagRepairWarning)]


def bags_among(paths: Sequence[Path]) -> tuple[list[Path], list[str]]:
    """Return the bags among paths, and a note on each other path: a glob also matches files beside bags.

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


def _reject_copies(bags: Sequence[Path], recordings: Sequence[Recording]) -> None:
    for k, one in enumerate(recordings):
        for j, earlier in enumerate(recordings[:k]):
            if _is_copy(one.flight, earlier.flight):
                raise BagError(f"bags {bags[j]} and {bags[k]} hold the same flight; give each flight once")


def _is_copy(one: Flight, other: Flight) -> bool:
    """Return whether two flights are equal in every array."""
    if one.names != other.names or one.t.shape != other.t.shape:
        return False
    arrays = [field.name for field in fields(Flight) if field.name not in {"name", "names"}]
    return all(np.array_equal(getattr(one, name), getattr(other, name), equal_nan=True) for name in arrays)


def _reject_duplicates(bags: Sequence[Path]) -> None:
    duplicates = sorted({str(bag) for bag in bags if bags.count(bag) > 1})
    if duplicates:
        raise BagError(f"bag {', '.join(duplicates)} is given twice; give each flight once")
