"""Files of tables: Parquet and CSV."""

from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path

import numpy as np

from q2q_model.signals.values import Array
from q2q_model.signals.vehicle_name import LONGEST_SHOWN

TABLES = (".parquet", ".csv")
"""Suffixes of tables."""


def read_columns(path: Path) -> Mapping[str, Array]:
    """Return a table file's columns as float64, (rows,) each.

    Raises ValueError for a file of another kind, or one that cannot be read; FileNotFoundError for none.
    """
    if not path.exists():
        raise FileNotFoundError(f"no file {path}")
    if path.suffix not in TABLES:
        raise ValueError(f"{path} is neither .parquet nor .csv")
    try:
        from pyarrow import ArrowException, csv, parquet
    except ImportError as missing:
        raise ValueError(f"{path} needs pyarrow, which is missing: `pip install pyarrow`") from missing
    try:
        table = parquet.read_table(path) if path.suffix == ".parquet" else csv.read_csv(path)
        _check_names(table.column_names)
        return {name: _numbers(name, table[name].to_numpy()) for name in table.column_names}
    except (ArrowException, ValueError) as damage:
        raise ValueError(f"{path} is not a table of numbers: {damage}") from damage


def _check_names(columns: Sequence[str]) -> None:
    if twice := sorted(name for name, times in Counter(columns).items() if times > 1):
        raise ValueError(f"duplicate columns {', '.join(twice)}")


def _numbers(name: str, values: Collection[object]) -> Array:
    """Return a column as float64; raise ValueError, which names it, for texts, structs and lists."""
    try:
        return np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError) as wrong:
        raise ValueError(f"column {name[:LONGEST_SHOWN]}: {wrong}") from wrong
