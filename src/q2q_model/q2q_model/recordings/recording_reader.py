"""Recording of one file: a bag or a table (Parquet, CSV), with filtered states; the files in folders."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from q2q_model.bag import (
    BagError,
    TopicMap,
    is_bag,
    read_facts,
    read_flight,
    read_flight_log,
    read_mapped_flight,
)
from q2q_model.bag.log_topic import LOG_TYPE, has_log
from q2q_model.bag.storage.errors import warn_of_repairs
from q2q_model.flights.flight import Flight
from q2q_model.flights.flight_log import FlightLog, log_at
from q2q_model.flights.joined_flight import flight_from_signals
from q2q_model.flights.tables.flight_table import FlightTable, flight_table
from q2q_model.flights.tables.table_file import TABLES, read_columns
from q2q_model.flights.tables.table_log import log_of
from q2q_model.flights.tables.table_signals import signals_of
from q2q_model.flights.units_and_frames.unit_check import check_flight_metres
from q2q_model.recordings.filtered_states import with_filtered_states
from q2q_model.recordings.flight_recording import Recording
from q2q_model.recordings.impossible_values import possible_flight, possible_log


def flights_among(paths: Sequence[Path]) -> tuple[list[Path], list[str]]:
    """Return the bags and tables among paths and in folders, and a note on each other file."""
    found, notes = [], []
    for path in paths:
        if path.is_dir() and not is_bag(path):
            there = sorted(one for one in path.iterdir() if one.suffix in TABLES or is_bag(one))
            others = [one for one in there if one.suffix == ".csv" and not is_flight_csv(one)]
            if len(there) == len(others):
                raise ValueError(f"{path} is not a bag and contains neither bags nor flight tables")
            found += [one for one in there if one not in others]
            notes += [f"skipped: {one} has no column t, so it is not a flight" for one in others]
        elif path.suffix in TABLES or is_bag(path) or not path.exists():
            found.append(path)
        else:
            notes.append(f"skipped: {path} is neither a bag nor a table (.parquet, .csv)")
    if not found:
        raise ValueError("; ".join(notes))
    return found, notes


def is_flight_csv(path: Path) -> bool:
    """Return whether a CSV file has a column t, as a flight has and a list of flights has not."""
    with path.open(encoding="utf-8", errors="replace") as stream:
        return "t" in [name.strip().strip('"') for name in stream.readline().split(",")]


def recording_of_table(path: Path) -> Recording:
    """Return the flight in a table; raise ValueError if it cannot be read or no vehicle has a position."""
    columns = read_columns(path)
    try:
        flight, log = _flight_and_log(path.stem, flight_table(columns))
    except ValueError as wrong:
        raise ValueError(f"table {path}: {wrong}") from wrong
    if not flight.names:
        raise ValueError(f"table {path}: no vehicle has a position: x, y, z in a row whose gap is 0")
    return _recording(flight, log_at(log, flight.t, flight.names) if log.columns else None)


def _flight_and_log(name: str, table: FlightTable) -> tuple[Flight, FlightLog]:
    signals = {topic.removeprefix("/"): list(rows) for topic, rows in signals_of(table).items()}
    return flight_from_signals(name, signals).flight, log_of(table)


def recording_of_bag(bag: Path, topics: TopicMap | None = None) -> Recording:
    """Return the flight in a bag with its log, as `flight_of_bag` reads it.

    Raises:
        BagError: the bag or its log cannot be read, or flight and log do not fit.
        ValueError: its positions are not in metres, or no vehicle has one.
    """
    flight = flight_of_bag(bag, topics)
    if not flight.names:
        raise ValueError(f"bag {bag}: no vehicle has a position; record the topic mocap or state")
    log = _log(bag)
    try:
        own = log_at(log, flight.t, flight.names) if log else None
    except ValueError as misfit:
        raise BagError(f"bag {bag}: {misfit}") from misfit
    return replace(_recording(flight, own), model=read_facts(bag).model)


def flight_of_bag(bag: Path, topics: TopicMap | None = None) -> Flight:
    """Return the flight in a bag, by a map if other software wrote it.

    Raises:
        BagError: the bag cannot be read.
        ValueError: its positions are not in metres.
    """
    flight = read_flight(bag) if topics is None else read_mapped_flight(bag, topics)
    check_flight_metres(flight)
    return flight


def _recording(flight: Flight, log: FlightLog | None) -> Recording:
    """Return the recording of a flight, without impossible values; each is a BagRepairWarning."""
    known, remarks = possible_flight(flight)
    own, of_log = possible_log(log) if log is not None else (None, [])
    warn_of_repairs(tuple(f"flight {flight.name}: {remark}" for remark in (*remarks, *of_log)))
    whole = with_filtered_states(known)
    return Recording(whole, own, filtered=whole is not known)


def _log(bag: Path) -> FlightLog | None:
    """Return a bag's log of additional columns; None if it has none, by its metadata where possible.

    Raises:
        BagError: it cannot be read, or its vehicles or columns change.
    """
    metadata = bag / "metadata.yaml"
    if metadata.is_file() and LOG_TYPE not in metadata.read_text(encoding="utf-8", errors="replace"):
        return None
    return read_flight_log(bag) if has_log(bag) else None
