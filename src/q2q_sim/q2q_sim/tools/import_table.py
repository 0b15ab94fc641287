"""Convert a recorded flight to a bag: a table (Parquet or CSV), or the micro-SD logs of its vehicles."""

import re
from argparse import Namespace
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from q2q_model.bag import LOG_TOPIC, BagWriter, FlightFacts, write_log_row
from q2q_model.counted import counted
from q2q_model.flights.tables.column_map import FIRMWARE, ColumnMap, load_column_map, mapped_table
from q2q_model.flights.tables.flight_table import (
    ACC,
    ANGLES,
    CARRIED,
    POS,
    FlightTable,
    attitude,
    flight_table,
)
from q2q_model.flights.tables.table_file import TABLES, read_columns
from q2q_model.flights.tables.table_log import log_of
from q2q_model.flights.tables.table_signals import signals_of
from q2q_model.flights.tables.table_vehicles import vehicle_prefixes
from q2q_model.flights.tables.usd_flight import clock_note, columns_of_logs
from q2q_model.flights.tables.usd_log import UsdLog, UsdLogError, is_usd_log, usd_log
from q2q_model.flights.units_and_frames.gravity_check import gravity_note
from q2q_model.flights.units_and_frames.tilt_direction import tilt_direction_reason
from q2q_model.flights.units_and_frames.up_axis import up_axis_reason
from q2q_model.signals.stamps import stamp_from_time
from q2q_model.signals.values import Array

NEEDS = (
    "/state needs vx, vy, vz, /imu ax, ay, az, each with qx, qy, qz, qw or roll_rad, "
    "pitch_rad, yaw_rad, and /reference xref, yref, zref"
)
UNITLESS = (
    "the unit of roll, pitch, yaw is not known: a column map (--columns) makes them the attitude, like "
    "roll_rad: {from: roll, scale: 0.0174533}; 1 for radians, 0.0174533 for degrees, -0.0174533 for the "
    "firmware's pitch, which is nose up"
)


def run(args: Namespace) -> int:
    """Convert the flight; print what is in the bag; return the exit status."""
    chosen = load_column_map(args.columns) if args.columns else None
    columns, notes = _columns(args.flight, args.names, chosen)
    table = flight_table(columns)
    counts = write_bag(table, args.out, FlightFacts(vehicle=args.vehicle))
    _print_vehicles(columns, len(table.t), args.out)
    for topic, count in counts.items():
        print(f"  {topic}: {counted(count, 'message')}")
    if lone := [name for name in log_of(table).columns if name in CARRIED]:
        print(f"  in /log, as other columns are missing: {', '.join(lone)}; {NEEDS}")
    if set(ANGLES) <= set(lone):
        print(f"  {UNITLESS}")
    unseen = table.gap | ~np.isfinite(table.vectors(POS)).all(axis=-1)
    print(f"  {counted(int(unseen.sum()), 'sample')} in gaps of the source: not in /mocap")
    with_gravity = gravity_note(table.t, table.names, table.columns["az"]) if table.has(ACC) else ""
    leans = tilt_direction_reason(table.t, table.names, table.vectors(POS), attitude(table))
    for note in filter(None, [*notes, up_axis_reason(table.vectors(POS)), leans, with_gravity]):
        print(f"  {note}")
    if not args.vehicle:
        print("  its vehicle is not named; --vehicle names it for the tools that read the bag")
    return 0


def _print_vehicles(columns: Mapping[str, Array], ticks: int, out: Path) -> None:
    """Print which columns became positions of a vehicle, and which are of none."""
    prefixes = vehicle_prefixes(tuple(columns), CARRIED)
    placed = [f"{name} ({key}x, {key}y, {key}z)" for name, key in prefixes.items()]
    print(f"{out}: {counted(ticks, 'tick')} of {', '.join(placed)}")
    lost = [name for name in columns if name != "t" and not name.startswith(tuple(prefixes.values()))]
    if lost:
        print(
            "  left out, as they belong to no vehicle: "
            f"{', '.join(name or 'a column without a name' for name in lost)}"
        )


def _columns(
    paths: Sequence[Path], names: str | None, chosen: ColumnMap | None
) -> tuple[Mapping[str, Array], list[str]]:
    """Return the columns of a flight, how clocks of its logs are joined, and what they lack."""
    if not any(is_usd_log(path.read_bytes()[:256]) for path in paths):
        if len(paths) > 1:
            raise ValueError(f"{', '.join(map(str, paths))}: give one table, or micro-SD logs only")
        if paths[0].suffix not in TABLES:
            raise ValueError(f"{paths[0]} is neither a table (.parquet, .csv) nor a log of a micro-SD deck")
        columns = read_columns(paths[0])
        return (mapped_table(columns, chosen) if chosen else columns), []
    logs = read_logs(paths, names.split(",") if names else None, chosen)
    repairs = [f"{name}: left out {what}" for name, log in logs.items() for what in log.repairs]
    unread = [
        f"{name} also logs events that are not read: {', '.join(log.unread)}"
        for name, log in logs.items()
        if log.unread
    ]
    return columns_of_logs(logs, chosen), [clock_note(logs), *repairs, *unread]


def read_logs(
    paths: Sequence[Path], names: Sequence[str] | None, chosen: ColumnMap | None
) -> dict[str, UsdLog]:
    """Return each vehicle's micro-SD log; a vehicle is named by its file, up to the last _number.

    Raises ValueError for a file that is no such log, and for names that are not one each.
    """
    found = list(names) if names else [re.sub(r"[_-]?\d+$", "", path.stem) or path.stem for path in paths]
    if len(found) != len(paths) or len(set(found)) < len(found):
        raise ValueError(
            f"{len(paths)} logs, vehicles {', '.join(found)}: give --names, a different one each"
        )
    logs = {}
    for name, path in zip(found, paths, strict=True):
        try:
            logs[name] = usd_log(path.read_bytes(), {**FIRMWARE, **(chosen or {})})
        except UsdLogError as damage:
            raise ValueError(f"{path} is not a log of a micro-SD deck: {damage}") from damage
    return logs


def write_bag(table: FlightTable, path: Path, facts: FlightFacts | None = None) -> dict[str, int]:
    """Write a table as a bag with facts about the flight; return the number of messages on each topic."""
    log, signals = log_of(table), signals_of(table)
    with BagWriter(path, facts=facts) as bag:
        for row, together in enumerate(zip(*signals.values(), strict=True)):
            for topic, signal in zip(signals, together, strict=True):
                bag.write_signal(topic, stamp_from_time(signal.t), signal)
            if log.columns:
                write_log_row(bag, log, row)
    topics = [*signals, LOG_TOPIC] if log.columns else list(signals)
    return dict.fromkeys(topics, len(table.t))
