"""Files of tables that are refused, and why."""

from pathlib import Path

import pyarrow as pa
import pytest
from pyarrow import parquet

from q2q_model.flights.tables.table_file import read_columns


def test_a_column_that_is_there_twice_is_named(tmp_path: Path) -> None:
    path = tmp_path / "flight.csv"
    path.write_text("t,x,y,z,z\n0,1,2,3,4\n")
    with pytest.raises(ValueError, match="is not a table of numbers: duplicate columns z"):
        read_columns(path)


def test_a_column_that_holds_no_numbers_is_named(tmp_path: Path) -> None:
    path = tmp_path / "flight.parquet"
    for values in ([{"x": 1.0}, {"x": 2.0}], ["here", "there"], [[1.0, 2.0], [3.0]]):
        parquet.write_table(pa.table({"t": [0.0, 0.01], "pose": values}), path)
        with pytest.raises(ValueError, match=r"flight\.parquet is not a table of numbers: column pose: "):
            read_columns(path)
