"""Turn a recorded flight in a table (Parquet or CSV) into a bag: `ros2 run q2q_sim bag_import`."""

from argparse import Namespace
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from q2q_model.bag import LOG_TOPIC, BagWriter, write_log_row
from q2q_model.flights.flight_table import FlightTable, flight_table, log_of, signals_of
from q2q_model.signals.values import Array


def run(asked: Namespace) -> int:
    """Convert the table; print what is in the bag; return the exit status."""
    table = flight_table(read_columns(asked.table))
    counts = write_bag(table, asked.out)
    print(f"{asked.out}: {len(table.t)} ticks of {', '.join(table.names)}")
    for topic, count in counts.items():
        print(f"  {topic}: {count} messages")
    print(f"  {int(table.gap.sum())} samples lie in gaps of the source: not in /mocap")
    return 0


def read_columns(path: Path) -> Mapping[str, Array]:
    """Return a table file's columns as float64.

    Raises ValueError for a file of another kind, or one that cannot be read; FileNotFoundError for none.
    """
    if not path.exists():
        raise FileNotFoundError(f"no file {path}")
    if path.suffix not in (".parquet", ".csv"):
        raise ValueError(f"{path} is neither .parquet nor .csv")
    from pyarrow import ArrowException, csv, parquet

    try:
        table = parquet.read_table(path) if path.suffix == ".parquet" else csv.read_csv(path)
        return {name: np.asarray(table[name].to_numpy(), dtype=np.float64) for name in table.column_names}
    except (ArrowException, ValueError) as damage:
        raise ValueError(f"{path} is no table of numbers: {damage}") from damage


def write_bag(table: FlightTable, path: Path) -> dict[str, int]:
    """Write a table as a bag; return the number of messages on each topic."""
    log, signals = log_of(table), signals_of(table)
    with BagWriter(path) as bag:
        for row, together in enumerate(zip(*signals.values(), strict=True)):
            for topic, signal in zip(signals, together, strict=True):
                bag.write_signal(topic, round(signal.t * 1e9), signal)
            if log.columns:
                write_log_row(bag, log, row)
    topics = [*signals, LOG_TOPIC] if log.columns else list(signals)
    return dict.fromkeys(topics, len(table.t))
