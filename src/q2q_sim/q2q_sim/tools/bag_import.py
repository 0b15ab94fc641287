"""Turn a recorded flight in a table (Parquet or CSV) into a bag: `ros2 run q2q_sim bag_import`."""

import sys
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from q2q_model.bag import LOG_TOPIC, BagWriter, write_log_row
from q2q_model.signals import Array
from q2q_model.tools.command_line import CommandLine, without_ros
from q2q_sim.flight_table import FlightTable, flight_table, log_of, signals_of


def main(arguments: list[str] | None = None) -> int:
    """Convert as the command line says; return 0, or 1 after an error."""
    parser = CommandLine("bag_import", __doc__, "  ros2 run q2q_sim bag_import flight.parquet --out flight")
    parser.add_argument(
        "table", type=Path, help="flight as .parquet or .csv: t, then <vehicle>_x ... or x ..."
    )
    parser.add_argument(
        "--out", type=Path, required=True, metavar="BAG", help="folder to write; must not exist"
    )
    given = parser.parse_args(without_ros(arguments))
    try:
        table = flight_table(read_columns(given.table))
        counts = write_bag(table, given.out)
    except (ValueError, OSError) as wrong:
        print(f"bag_import: {wrong}", file=sys.stderr)
        return 1
    print(f"{given.out}: {len(table.t)} ticks of {', '.join(table.names)}")
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


if __name__ == "__main__":
    sys.exit(main())
