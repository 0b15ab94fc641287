"""Rows of a table, by case and as numbers."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby

import numpy as np

from q2q_model.signals.values import Array

CheckRow = Mapping[str, str]
CheckTable = Sequence[CheckRow]


def cases(table: CheckTable) -> Iterator[list[CheckRow]]:
    """Yield the rows of each case in turn."""
    for _, rows in groupby(table, key=lambda row: row["case"]):
        yield list(rows)


def row_numbers(row: CheckRow, columns: Sequence[str]) -> Array:
    """Return columns of a row, (len(columns),)."""
    return np.array([float(row[name]) for name in columns])
