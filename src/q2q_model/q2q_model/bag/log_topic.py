"""The topic `log`: q2q_msgs/FlightLog, one message per tick."""

from pathlib import Path
from typing import Protocol

import numpy as np

from q2q_model.bag.reader import BagReader
from q2q_model.bag.storage.definitions import jazzy_types, naming_message
from q2q_model.bag.storage.errors import BagError
from q2q_model.bag.storage.source import RawMessage
from q2q_model.bag.writer import BagWriter
from q2q_model.flights.flight_log import FlightLog
from q2q_model.signals.stamps import stamp_from_parts, stamp_from_time, stamp_parts, time_from_stamp
from q2q_model.signals.values import Array

LOG_TOPIC = "/log"
LOG_TYPE = "q2q_msgs/msg/FlightLog"


class _Stamp(Protocol):
    sec: int
    nanosec: int


class _Header(Protocol):
    stamp: _Stamp


class _Row(Protocol):
    """Decoded q2q_msgs/FlightLog."""

    header: _Header
    names: list[str]
    columns: list[str]
    units: list[str]
    values: Array


def write_log_row(bag: BagWriter, log: FlightLog, row: int) -> None:
    """Write one tick of a log to the topic /log of a bag."""
    types = jazzy_types().types
    stamp_ns = stamp_from_time(float(log.t[row]))
    sec, nanosec = stamp_parts(stamp_ns)
    header = types["std_msgs/msg/Header"](
        stamp=types["builtin_interfaces/msg/Time"](sec=sec, nanosec=nanosec), frame_id="world"
    )
    message = types[LOG_TYPE](
        header=header,
        names=list(log.names),
        columns=list(log.columns),
        units=list(log.units),
        values=np.ascontiguousarray(log.values[row], dtype=np.float64).ravel(),
    )
    bag.add_topic(LOG_TOPIC, LOG_TYPE)
    bag.write_raw(LOG_TOPIC, stamp_ns, bytes(jazzy_types().serialize_cdr(message, LOG_TYPE)))


def has_log(path: Path | str) -> bool:
    """Return whether a bag has a message of a log; raise BagError if it cannot be read."""
    return any(one.type_name == LOG_TYPE and one.count > 0 for one in BagReader(path).channels)


def read_flight_log(path: Path | str) -> FlightLog:
    """Return the log of a flight.

    Raises BagError for a bag without one, or if its vehicles or columns change during the flight.
    """
    bag = BagReader(path)
    topic = next((name for name, kind in bag.topics.items() if kind == LOG_TYPE), None)
    if topic is None:
        raise BagError(f"bag {bag.path} has no {LOG_TYPE}; it has {', '.join(bag.topics.values())}")
    rows = [_decoded(bag, found) for found in bag.raw({topic})]
    if not rows:
        raise BagError(f"bag {bag.path} has no message on {topic}")
    heads = {(tuple(row.names), tuple(row.columns), tuple(row.units)) for row in rows}
    if len(heads) > 1:
        raise BagError(
            f"bag {bag.path}: vehicles or columns of {topic} change during the flight; split the bag there"
        )
    ((names, columns, units),) = heads
    t = [time_from_stamp(stamp_from_parts(row.header.stamp.sec, row.header.stamp.nanosec)) for row in rows]
    lengths = {len(row.values) for row in rows}
    if lengths != {len(names) * len(columns)}:
        needs = f"{len(names)} vehicles and {len(columns)} columns need {len(names) * len(columns)}"
        raise BagError(f"bag {bag.path}: {topic} has rows of {sorted(lengths)} numbers; {needs}")
    values = np.stack([row.values for row in rows]).reshape(len(rows), len(names), len(columns))
    return FlightLog(np.array(t), names, columns, units, values)


def _decoded(bag: BagReader, found: RawMessage) -> _Row:
    with naming_message(bag.path, found, LOG_TYPE):
        message: _Row = jazzy_types().deserialize_cdr(found.data, LOG_TYPE)
    return message
