"""The vehicles of a table are those of its positions; a table that is no flight is refused."""

from pathlib import Path

import numpy as np
import pytest
from table_columns import table_columns, vectors, write_csv

from q2q_model.bag import read_flight, read_flight_log
from q2q_model.flights.tables.flight_table import flight_table
from q2q_model.flights.tables.table_signals import signals_of
from q2q_model.signals.values import Array
from q2q_sim.commands.bag_import import main


def test_a_state_in_a_gap_coasts_and_grows_old() -> None:
    states = list(signals_of(flight_table(table_columns()))["/state"])
    assert [int(state.status[1]) for state in states[9:16]] == [0, 1, 1, 1, 1, 1, 0]
    assert np.allclose(
        [state.age[1] for state in states[9:16]], [0, 0.01, 0.02, 0.03, 0.04, 0.05, 0], atol=1e-9
    )
    assert all(state.age[0] == 0.0 for state in states)


def test_a_lone_vehicle_has_plain_columns_and_nothing_where_nothing_is_logged() -> None:
    t = np.arange(50) * 0.01
    columns = {
        "t": t,
        "x": t,
        "y": t,
        "z": t,
        "xref": t**2,
        "yref": 0 * t,
        "zref": 0 * t,
        "yawref_deg": 90.0 + 0 * t,
    }
    table = flight_table(columns)
    made = {topic: list(signals) for topic, signals in signals_of(table).items()}
    assert set(made) == {"/mocap", "/reference"}
    assert table.names == ("cf1",)
    assert np.isnan(made["/mocap"][0].quat).all()
    assert [s.pos[0, 0] for s in made["/reference"]] == (t**2).tolist()
    assert all(np.isnan(s.vel).all() and np.isnan(s.acc).all() for s in made["/reference"])
    assert made["/reference"][0].yaw[0] == pytest.approx(np.pi / 2)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"t": None}, "has no column t"),
        ({"t": np.zeros(40)}, "must begin at 0 or later and increase; row 1 of 40"),
        ({"t": np.arange(40) - 5.0}, "row 0 of 40"),
        (
            {name: values[:0] for name, values in table_columns().items()},
            "has 0 rows; must be at least 2",
        ),
        ({name: values[:1] for name, values in table_columns().items()}, "has 1 row; must be at least 2"),
        ({"t": 10.0 * np.arange(40)}, r"t steps by 10 s \(maximum 0\.5 s\): check that it is in seconds"),
        (
            {"t": 2.0**31 + np.arange(40) * 0.01},
            r"t ends at 2147483648 s, but stamps must be below 2147397248 s \(32 bits\): subtract the first",
        ),
        ({"t": np.append(np.arange(39) * 0.01, np.inf)}, "t ends at inf s, but stamps must be below"),
        ({"cf50_z": np.full(40, 1000.0)}, r"x, y, z of cf50 reach 1000 m in the median \(maximum 50 m\)"),
        ({"cf50_zref": np.full(40, 1000.0)}, "x, y, z of the reference of cf50 reach 1000 m in the median"),
        ({"cf50_x": None, "cf51_x": None}, "neither x, y, z nor <vehicle>_x, _y, _z"),
    ],
)
def test_a_table_that_is_no_flight_is_named(change: dict[str, Array | None], message: str) -> None:
    columns = {name: change.get(name, values) for name, values in table_columns().items()}
    with pytest.raises(ValueError, match=message):
        flight_table({name: values for name, values in columns.items() if values is not None})


@pytest.mark.parametrize("name", ["1", "v" * 101, "é", "cf-2", "Drone A", "room.cf2"])
def test_a_vehicle_with_a_name_that_begins_no_topic_is_refused(name: str) -> None:
    with pytest.raises(
        ValueError, match="letters, digits and _, at most 100: rename its columns, as in cf1_x"
    ):
        flight_table(vectors("cf1_", f"{name}_"))


@pytest.mark.parametrize("name", ["cf1.gyro", "cf1-est", "cf1 mag"])
def test_another_vector_of_a_vehicle_is_left_out(name: str) -> None:
    assert flight_table(vectors("cf1_", f"{name}_")).names == ("cf1",)


def test_another_vector_of_a_lone_vehicle_is_no_vehicle(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_csv(vectors("", "gyro_"), tmp_path / "flight.csv")
    assert main([str(tmp_path / "flight.csv"), "--out", str(tmp_path / "bag")]) == 0
    assert "40 ticks of cf1 (x, y, z)" in capsys.readouterr().out
    flight, log = read_flight(tmp_path / "bag"), read_flight_log(tmp_path / "bag")
    assert flight.names == ("cf1",)
    assert np.all(flight.mocap_pos == 0.0)
    assert np.all(log.column("gyro_x") == 1.0)


def test_an_estimate_of_a_vehicle_is_in_the_log_of_that_vehicle() -> None:
    table = flight_table(vectors("cf1_", "cf1_est_", "cf2_", "cf2_est_"))
    assert table.names == ("cf1", "cf2")
    assert table.columns["x"][0].tolist() == [0.0, 2.0]
    assert table.columns["est_x"][0].tolist() == [1.0, 3.0]


def test_a_vector_without_all_three_axes_is_no_vehicle(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    columns = vectors("wind_", "cf1_")
    del columns["wind_z"]
    write_csv(columns, tmp_path / "flight.csv")
    assert main([str(tmp_path / "flight.csv"), "--out", str(tmp_path / "bag")]) == 0
    out = capsys.readouterr().out
    assert "40 ticks of cf1 (cf1_x, cf1_y, cf1_z)" in out
    assert "left out, as they belong to no vehicle: wind_x, wind_y" in out


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        (vectors("", "cf2_"), "cf2 may be a vehicle.* the table has x, y, z and cf2_x, cf2_y, cf2_z;"),
        (vectors("drone_", "drone_2_"), "drone_2 may be a vehicle.* drone_y, drone_z and drone_2_x"),
        (vectors("", "left_") | {"left_qw": np.ones(40)}, "left may be a vehicle.* left_z, left_qw"),
    ],
)
def test_a_table_of_one_vehicle_or_of_several_is_refused(columns: dict[str, Array], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        flight_table(columns)


def test_positions_of_a_vehicle_whose_name_has_a_space_are_refused_with_that_name() -> None:
    columns = {"t": np.arange(5) * 0.01} | {f"Drone A_{axis}": np.zeros(5) for axis in "xyz"}
    with pytest.raises(
        ValueError, match=r"vehicle 'Drone A': a name must be a letter .*: rename its columns"
    ):
        flight_table(columns)


def test_a_column_without_a_name_is_listed_as_such(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table = tmp_path / "indexed.csv"  # as pandas writes it with its index
    table.write_text(",t,cf1_x,cf1_y,cf1_z\n0,0.0,0,0,1\n1,0.1,0,0,1\n")
    assert main([str(table), "--out", str(tmp_path / "bag")]) == 0
    assert "left out, as they belong to no vehicle: a column without a name\n" in capsys.readouterr().out
