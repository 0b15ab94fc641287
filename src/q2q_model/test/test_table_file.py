"""Files of tables that are refused, and why."""

from pathlib import Path

import pytest

from q2q_model.flights.tables.table_file import read_columns


def test_a_column_that_is_there_twice_is_named(tmp_path: Path) -> None:
    path = tmp_path / "flight.csv"
    path.write_text("t,x,y,z,z\n0,1,2,3,4\n")
    with pytest.raises(ValueError, match="is not a table of numbers: it has these columns more than once: z"):
        read_columns(path)
