"""The import of a flight's table changes nothing on the way through the bag, and says what it left out."""

import os
from pathlib import Path

import numpy as np
import pytest
from table_columns import table_columns, vectors, write_csv

from q2q_model.bag import BagReader, read_facts, read_flight, read_flight_log
from q2q_model.flights.tables.table_file import read_columns
from q2q_model.geometry.rotations import euler_from_quat, rotate
from q2q_model.recordings.bag_vehicle import flown_vehicle
from q2q_model.vehicle.constants import CRAZYFLIE_2_1, GRAVITY
from q2q_sim.commands.bag_import import main

DATA = Path(os.environ.get("Q2Q_DATA", Path(__file__).parents[4].parent / "shared" / "data"))
NEEDS_DATA = pytest.mark.skipif(not DATA.is_dir(), reason=f"real flights are not at {DATA}: set Q2Q_DATA")


def test_every_column_survives_the_bag(tmp_path: Path) -> None:
    columns = table_columns()
    write_csv(columns, tmp_path / "flight.csv")
    assert main([str(tmp_path / "flight.csv"), "--out", str(tmp_path / "bag")]) == 0
    flight, log = read_flight(tmp_path / "bag"), read_flight_log(tmp_path / "bag")
    assert flight.names == log.names == ("cf50", "cf51")
    assert np.allclose(flight.t, columns["t"], atol=1e-9)
    for k, name in enumerate(flight.names):
        kept = {
            "x": flight.pos[:, k, 0], "vz": flight.vel[:, k, 2], "xref": flight.ref_pos[:, k, 0],
            "vyref": flight.ref_vel[:, k, 1], "thrust_cmd": flight.thrust[:, k],
            "wq": flight.gyro_body[:, k, 1],
        }  # fmt: skip
        for key in ("pwm1", "pwm4", "vbat", "fa_ff", "thrust_est", "faz_est", "gap"):
            kept[key] = log.column(key)[:, k]
        for key, values in kept.items():
            assert np.array_equal(values, columns[f"{name}_{key}"]), key
        # one rotation there and back of numbers near 10
        acc = rotate(flight.quat[:, k], flight.specific_force_body[:, k]) - [0.0, 0.0, GRAVITY]
        assert np.allclose(acc, np.stack([columns[f"{name}_a{axis}"] for axis in "xyz"], axis=1), atol=1e-13)
    gone = np.isnan(flight.mocap_pos).any(axis=-1)
    assert gone[10:15, 1].all()
    assert gone.sum() == 5
    assert np.array_equal(flight.mocap_pos[~gone], flight.pos[~gone])
    assert log.units[log.columns.index("faz_est")] == "N"


def test_an_imported_bag_names_its_vehicle(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_csv(table_columns(), tmp_path / "flight.csv")
    given = [str(tmp_path / "flight.csv"), "--out"]
    assert main([*given, str(tmp_path / "named"), "--vehicle", "crazyflie_2_1"]) == 0
    assert "not named" not in capsys.readouterr().out
    flown = flown_vehicle(tmp_path / "named")
    assert (flown.vehicle, flown.note) == (CRAZYFLIE_2_1, "")
    assert main([*given, str(tmp_path / "silent")]) == 0
    assert "its vehicle is not named; --vehicle" in capsys.readouterr().out
    assert read_facts(tmp_path / "silent").vehicle == ""
    with pytest.raises(SystemExit):
        main([*given, str(tmp_path / "wrong"), "--vehicle", "crazyflie_2_2"])
    assert "did you mean crazyflie_2_" in capsys.readouterr().err


def test_rows_without_a_position_are_counted_as_gaps(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    columns = {name: values.copy() for name, values in table_columns().items()}
    columns["cf50_y"][3:10] = np.nan
    write_csv(columns, tmp_path / "flight.csv")
    assert main([str(tmp_path / "flight.csv"), "--out", str(tmp_path / "bag")]) == 0
    unseen = np.isnan(read_flight(tmp_path / "bag").mocap_pos).any(axis=-1).sum()
    assert f"{unseen} samples in gaps of the source: not in /mocap" in capsys.readouterr().out
    assert unseen == 7 + 5


@pytest.mark.parametrize(("up", "doubted"), [("z", False), ("y", True)])
def test_a_table_whose_y_is_up_is_doubted(
    up: str, *, doubted: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    columns = vectors("") | {"y": np.linspace(-1.0, 1.0, 40), "z": np.ones(40)}
    if up == "y":
        columns |= {"y": columns["z"], "z": -columns["y"]}
    write_csv(columns, tmp_path / "flight.csv")
    assert main([str(tmp_path / "flight.csv"), "--out", str(tmp_path / "bag")]) == 0
    report = "  z is below -0.1 m in 45% of the positions and y in 0%: y may be up"
    assert (report in capsys.readouterr().out) is doubted


@pytest.mark.parametrize(("reads", "doubted"), [(0.0, False), (1.0, True), (GRAVITY, True)])
def test_accelerations_with_gravity_are_doubted(
    reads: float, doubted: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    columns = vectors("", "a")
    t = 10.0 * columns["t"]  # 3.9 s
    write_csv(columns | {"t": t, "az": np.full(40, reads)}, tmp_path / "flight.csv")
    assert main([str(tmp_path / "flight.csv"), "--out", str(tmp_path / "bag")]) == 0
    assert (
        f"its median must be near 0, but is {reads:.2f} m/s^2 (cf1)" in capsys.readouterr().out
    ) is doubted


def test_errors_of_the_tool_are_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "words.csv").write_text("t,x,y,z\n0,a,b,c\n")
    (tmp_path / "cut.parquet").write_bytes(b"PAR1 and no more")
    (tmp_path / "flight.txt").write_text("")
    write_csv(table_columns(), tmp_path / "good.csv")
    (tmp_path / "there").mkdir()
    for file, out, message in (
        ("none.csv", "bag", "no flight at"),
        ("flight.txt", "bag", "neither a table (.parquet, .csv) nor a log"),
        ("words.csv", "bag", "is not a table of numbers"),
        ("cut.parquet", "bag", "is not a table of numbers"),
        ("good.csv", "there", "exists already"),
    ):
        assert main([str(tmp_path / file), "--out", str(tmp_path / out)]) == 1
        error = capsys.readouterr().err
        assert message in error
        assert error.count("\n") == 1
    assert not (tmp_path / "bag").exists()


def test_what_is_in_the_log_for_lack_of_other_columns_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    columns = {
        name: one for name, one in table_columns().items() if not name.endswith(("_qw", "_yaw", "_fa_ff"))
    }
    write_csv(columns, tmp_path / "flight.csv")
    assert main([str(tmp_path / "flight.csv"), "--out", str(tmp_path / "bag")]) == 0
    named = "vx, vy, vz, ax, ay, az, roll, pitch, qx, qy, qz, wp, wq, wr"
    assert (
        f"  in /log, as other columns are missing: {named}; /state needs vx, vy, vz, /imu ax"
        in capsys.readouterr().out
    )
    log = read_flight_log(tmp_path / "bag")
    assert np.array_equal(log.column("vz")[:, 1], columns["cf51_vz"])
    assert log.units[log.columns.index("vz")] == "m/s"


def test_how_angles_become_the_attitude_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    columns = {name: one for name, one in table_columns().items() if not name.endswith("_qw")}
    write_csv(columns, tmp_path / "flight.csv")
    turned = "columns: {roll_rad: roll, pitch_rad: {from: pitch, scale: -1.0}, yaw_rad: yaw}"
    (tmp_path / "map.yaml").write_text(turned)
    assert main([str(tmp_path / "flight.csv"), "--out", str(tmp_path / "bag")]) == 0
    told = "roll_rad: {from: roll, scale: 0.0174533}; 1 for radians"
    assert told in capsys.readouterr().out
    mapped = ["--columns", str(tmp_path / "map.yaml"), "--out", str(tmp_path / "mapped")]
    assert main([str(tmp_path / "flight.csv"), *mapped]) == 0
    assert told not in capsys.readouterr().out
    pitch = euler_from_quat(read_flight(tmp_path / "mapped").quat[:, 0])[:, 1]
    np.testing.assert_allclose(np.sin(pitch), -np.sin(columns["cf50_pitch"]), atol=1e-12)


@NEEDS_DATA
@pytest.mark.parametrize(
    ("file", "topics"),
    [
        ("neural_swarm/dc21_swap_ss_03", {"/mocap", "/state", "/reference", "/command", "/imu", "/log"}),
        ("nanobench/B2_circle_fast_rep1", {"/mocap", "/reference", "/log"}),
    ],
)
def test_real_flights_are_imported(tmp_path: Path, file: str, topics: set[str]) -> None:
    path = DATA / f"{file}.parquet"
    assert main([str(path), "--out", str(tmp_path / "bag")]) == 0
    assert set(BagReader(tmp_path / "bag").topics) == topics
    flight, columns = read_flight(tmp_path / "bag"), read_columns(path)
    assert len(flight.t) == len(columns["t"])
    if "/state" in topics:
        # the logged quaternion has four digits, its length is off by up to 1e-4
        assert np.allclose(
            euler_from_quat(flight.quat[:, 0])[:, 0], columns[f"{flight.names[0]}_roll"], atol=1e-3
        )
