"""A column map renames and scales the columns of a table, and names only those that are there."""

from pathlib import Path

import numpy as np
import pytest
from line_log import log_of_a_line
from table_columns import table_columns, vectors, write_csv

from q2q_model.bag import read_flight, read_flight_log
from q2q_model.flights.tables.column_map import SourceColumn, mapped_table
from q2q_sim.commands.bag_import import main


def test_a_column_map_renames_and_scales_the_columns_of_a_table(tmp_path: Path) -> None:
    columns = {
        f"{key}_mm": 1e3 * values
        for key, values in table_columns().items()
        if key.endswith(("_x", "_y", "_z"))
    }
    write_csv({"t": table_columns()["t"]} | columns, tmp_path / "mm.csv")
    entries = "".join(
        f"  {name}: {{from: {name}_mm, scale: 0.001}}\n" for name in ("cf50_x", "cf50_y", "cf50_z")
    )
    (tmp_path / "map.yaml").write_text(f"columns:\n{entries}")
    given = [
        str(tmp_path / "mm.csv"),
        "--columns",
        str(tmp_path / "map.yaml"),
        "--out",
        str(tmp_path / "bag"),
    ]
    assert main(given) == 0
    flight = read_flight(tmp_path / "bag")
    assert flight.names == ("cf50",)
    np.testing.assert_allclose(flight.mocap_pos[:, 0, 0], table_columns()["cf50_x"], rtol=1e-12)


def test_a_column_map_without_vehicles_is_for_each_vehicle(tmp_path: Path) -> None:
    columns = vectors("cf1_pos_", "cf2_pos_", "cf2_est_pos_")
    write_csv(columns | {"cf2_mV": np.full(40, 3700.0)}, tmp_path / "mm.csv")
    entries = [f"  {axis}: {{from: pos_{axis}, scale: 0.5, offset: 1.0}}" for axis in "xyz"]
    entries.append("  vbat: {from: mV, scale: 0.001}")
    (tmp_path / "map.yaml").write_text("\n".join(["columns:", *entries]))
    given = [str(tmp_path / "mm.csv"), "--columns", str(tmp_path / "map.yaml")]
    assert main([*given, "--out", str(tmp_path / "bag")]) == 0
    flight, log = read_flight(tmp_path / "bag"), read_flight_log(tmp_path / "bag")
    assert flight.names == ("cf1", "cf2")
    assert flight.mocap_pos[0].tolist() == [[1.0] * 3, [1.5] * 3]
    assert log.column("vbat")[0, 1] == pytest.approx(3.7)
    assert np.isnan(log.column("vbat")[0, 0])


def test_a_column_map_of_a_lone_vehicle_leaves_other_vectors() -> None:
    columns = vectors("", "gyro_")
    found = mapped_table(columns, {"z": (SourceColumn("x", 1.0, 7.0),)})
    assert found.keys() == columns.keys()
    assert found["z"][0] == 7.0
    assert found["gyro_z"][0] == 1.0


def test_a_column_map_names_only_columns_that_are_there(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_csv(vectors("cf1_"), tmp_path / "flight.csv")
    (tmp_path / "cf1_00").write_bytes(log_of_a_line())
    (tmp_path / "map.yaml").write_text("columns: {vx: stateEstimate.vx_typo, y: xx}")
    for file, message in (
        ("flight.csv", "vx of the column map: no column stateEstimate.vx_typo; choose one of cf1_x, cf1_y"),
        ("cf1_00", "no column stateEstimate.vx_typo; did you mean stateEstimate."),
    ):
        given = [str(tmp_path / file), "--columns", str(tmp_path / "map.yaml")]
        assert main([*given, "--out", str(tmp_path / "bag")]) == 1
        assert message in capsys.readouterr().err
