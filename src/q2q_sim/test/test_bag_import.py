"""Tests of the import of real flights against its table: nothing changes on the way through the bag."""

import os
import struct
from pathlib import Path
from zlib import crc32

import numpy as np
import pytest

from q2q_model.bag import BagReader, read_facts, read_flight, read_flight_log
from q2q_model.flights.tables.column_map import SourceColumn, mapped_table
from q2q_model.flights.tables.flight_table import flight_table
from q2q_model.flights.tables.table_file import read_columns
from q2q_model.flights.tables.table_signals import signals_of
from q2q_model.geometry.rotations import euler_from_quat, rotate
from q2q_model.recordings.bag_vehicle import flown_vehicle
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import CRAZYFLIE_2_1, GRAVITY
from q2q_sim.commands.bag_import import main

DATA = Path(os.environ.get("Q2Q_DATA", Path(__file__).parents[3].parent / "shared" / "data"))
NEEDS_DATA = pytest.mark.skipif(not DATA.is_dir(), reason=f"real flights are not at {DATA}: set Q2Q_DATA")
ALL = (
    *("x", "y", "z", "vx", "vy", "vz", "ax", "ay", "az", "roll", "pitch", "yaw", "qx", "qy", "qz", "qw"),
    *("wp", "wq", "wr", "xref", "yref", "zref", "vxref", "vyref", "vzref", "thrust_cmd"),
    *("pwm1", "pwm2", "pwm3", "pwm4", "vbat", "fa_ff", "thrust_est", "faz_est", "gap"),
)


def _columns(ticks: int = 40) -> dict[str, Array]:
    rng = np.random.default_rng(0)
    columns = {"t": 0.01 * np.arange(1, ticks + 1)}
    for name in ("cf50", "cf51"):
        columns |= {f"{name}_{key}": rng.normal(size=ticks) for key in ALL}
        quat = rng.normal(size=(ticks, 4))
        quat /= np.linalg.norm(quat, axis=1, keepdims=True)
        columns |= {f"{name}_{key}": quat[:, k] for k, key in enumerate(("qx", "qy", "qz", "qw"))}
        columns[f"{name}_gap"] = np.zeros(ticks)
    columns["cf51_gap"][10:15] = 1.0
    return columns


def _write_csv(columns: dict[str, Array], path: Path) -> None:
    rows = np.stack(list(columns.values()), axis=1)
    np.savetxt(path, rows, delimiter=",", header=",".join(columns), comments="", fmt="%.17g")


def test_every_column_survives_the_bag(tmp_path: Path):
    columns = _columns()
    _write_csv(columns, tmp_path / "flight.csv")
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


def test_a_state_in_a_gap_coasts_and_grows_old():
    states = list(signals_of(flight_table(_columns()))["/state"])
    assert [int(state.status[1]) for state in states[9:16]] == [0, 1, 1, 1, 1, 1, 0]
    assert np.allclose(
        [state.age[1] for state in states[9:16]], [0, 0.01, 0.02, 0.03, 0.04, 0.05, 0], atol=1e-9
    )
    assert all(state.age[0] == 0.0 for state in states)


def test_a_lone_vehicle_has_plain_columns_and_nothing_where_nothing_is_logged():
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
        ({name: values[:1] for name, values in _columns().items()}, "has 1 row; a flight has 2 or more"),
        ({"t": 10.0 * np.arange(40)}, r"t steps by 10, 0\.5 s is the maximum: is it in seconds\?"),
        ({"cf50_z": np.full(40, 1000.0)}, "x, y, z of cf50 reach 1000 in the median, 50 m is the maximum"),
        ({"cf50_x": None, "cf51_x": None}, "neither x, y, z nor <vehicle>_x, _y, _z"),
    ],
)
def test_a_table_that_is_no_flight_is_named(change: dict[str, Array | None], message: str):
    columns = {name: change.get(name, values) for name, values in _columns().items()}
    with pytest.raises(ValueError, match=message):
        flight_table({name: values for name, values in columns.items() if values is not None})


def _vectors(*prefixes: str) -> dict[str, Array]:
    """Return t and a vector of each prefix: the x of the k-th is k."""
    t = 0.01 * np.arange(40)
    return {"t": t} | {f"{one}{axis}": k + 0.0 * t for k, one in enumerate(prefixes) for axis in "xyz"}


def _log_of_a_line(first_us: int = 0) -> bytes:
    """Return a micro-SD log of 2 s along x at 1 m/s."""
    variables = [f"stateEstimate.{axis}(f)" for axis in "xyz"]
    header = struct.pack("<BHHH", 0xBC, 2, 1, 0) + b"rows\0" + struct.pack("<H", 3)
    header += b"".join(one.encode() + b"\0" for one in variables)
    rows = b"".join(struct.pack("<HQfff", 0, first_us + 10_000 * k, 0.01 * k, 0.0, 1.0) for k in range(200))
    return header + rows + struct.pack("<I", crc32(header + rows))


def test_an_imported_bag_names_its_vehicle(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    _write_csv(_columns(), tmp_path / "flight.csv")
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
    columns = {name: values.copy() for name, values in _columns().items()}
    columns["cf50_y"][3:10] = np.nan
    _write_csv(columns, tmp_path / "flight.csv")
    assert main([str(tmp_path / "flight.csv"), "--out", str(tmp_path / "bag")]) == 0
    unseen = np.isnan(read_flight(tmp_path / "bag").mocap_pos).any(axis=-1).sum()
    assert f"{unseen} samples in gaps of the source: not in /mocap" in capsys.readouterr().out
    assert unseen == 7 + 5


def test_another_vector_of_a_lone_vehicle_is_no_vehicle(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    _write_csv(_vectors("", "gyro_"), tmp_path / "flight.csv")
    assert main([str(tmp_path / "flight.csv"), "--out", str(tmp_path / "bag")]) == 0
    assert "40 ticks of cf1 (x, y, z)" in capsys.readouterr().out
    flight, log = read_flight(tmp_path / "bag"), read_flight_log(tmp_path / "bag")
    assert flight.names == ("cf1",)
    assert np.all(flight.mocap_pos == 0.0)
    assert np.all(log.column("gyro_x") == 1.0)


@pytest.mark.parametrize(("up", "doubted"), [("z", False), ("y", True)])
def test_a_table_whose_y_is_up_is_doubted(
    up: str, *, doubted: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    columns = _vectors("") | {"y": np.linspace(-1.0, 1.0, 40), "z": np.ones(40)}
    if up == "y":
        columns |= {"y": columns["z"], "z": -columns["y"]}
    _write_csv(columns, tmp_path / "flight.csv")
    assert main([str(tmp_path / "flight.csv"), "--out", str(tmp_path / "bag")]) == 0
    report = "  z is below -0.1 m in 45% of the positions and y in 0%: is y up?"
    assert (report in capsys.readouterr().out) is doubted


def test_an_estimate_of_a_vehicle_is_in_the_log_of_that_vehicle():
    table = flight_table(_vectors("cf1_", "cf1_est_", "cf2_", "cf2_est_"))
    assert table.names == ("cf1", "cf2")
    assert table.columns["x"][0].tolist() == [0.0, 2.0]
    assert table.columns["est_x"][0].tolist() == [1.0, 3.0]


def test_a_vector_without_all_three_axes_is_no_vehicle(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    columns = _vectors("wind_", "cf1_")
    del columns["wind_z"]
    _write_csv(columns, tmp_path / "flight.csv")
    assert main([str(tmp_path / "flight.csv"), "--out", str(tmp_path / "bag")]) == 0
    out = capsys.readouterr().out
    assert "40 ticks of cf1 (cf1_x, cf1_y, cf1_z)" in out
    assert "left out, as of no vehicle: wind_x, wind_y" in out


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        (_vectors("", "cf2_"), "cf2 may be a vehicle.* the table has x, y, z and cf2_x, cf2_y, cf2_z;"),
        (_vectors("drone_", "drone_2_"), "drone_2 may be a vehicle.* drone_y, drone_z and drone_2_x"),
        (_vectors("", "left_") | {"left_qw": np.ones(40)}, "left may be a vehicle.* left_z, left_qw"),
    ],
)
def test_a_table_of_one_vehicle_or_of_several_is_refused(columns: dict[str, Array], message: str):
    with pytest.raises(ValueError, match=message):
        flight_table(columns)


def test_errors_of_the_tool_are_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    (tmp_path / "words.csv").write_text("t,x,y,z\n0,a,b,c\n")
    (tmp_path / "cut.parquet").write_bytes(b"PAR1 and no more")
    (tmp_path / "flight.txt").write_text("")
    _write_csv(_columns(), tmp_path / "good.csv")
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
):
    columns = {name: one for name, one in _columns().items() if not name.endswith(("_qw", "_yaw", "_fa_ff"))}
    _write_csv(columns, tmp_path / "flight.csv")
    assert main([str(tmp_path / "flight.csv"), "--out", str(tmp_path / "bag")]) == 0
    named = "vx, vy, vz, ax, ay, az, roll, pitch, qx, qy, qz, wp, wq, wr"
    assert (
        f"  in /log, for lack of other columns: {named}; /state needs vx, vy, vz, /imu ax"
        in capsys.readouterr().out
    )
    log = read_flight_log(tmp_path / "bag")
    assert np.array_equal(log.column("vz")[:, 1], columns["cf51_vz"])
    assert log.units[log.columns.index("vz")] == "m/s"


def test_how_angles_become_the_attitude_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    columns = {name: one for name, one in _columns().items() if not name.endswith("_qw")}
    _write_csv(columns, tmp_path / "flight.csv")
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
def test_real_flights_are_imported(tmp_path: Path, file: str, topics: set[str]):
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


def test_a_column_map_renames_and_scales_the_columns_of_a_table(tmp_path: Path):
    columns = {
        f"{key}_mm": 1e3 * values for key, values in _columns().items() if key.endswith(("_x", "_y", "_z"))
    }
    _write_csv({"t": _columns()["t"]} | columns, tmp_path / "mm.csv")
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
    np.testing.assert_allclose(flight.mocap_pos[:, 0, 0], _columns()["cf50_x"], rtol=1e-12)


def test_a_column_map_without_vehicles_is_for_each_vehicle(tmp_path: Path):
    columns = _vectors("cf1_pos_", "cf2_pos_", "cf2_est_pos_")
    _write_csv(columns | {"cf2_mV": np.full(40, 3700.0)}, tmp_path / "mm.csv")
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


def test_a_column_map_of_a_lone_vehicle_leaves_other_vectors():
    columns = _vectors("", "gyro_")
    found = mapped_table(columns, {"z": (SourceColumn("x", 1.0, 7.0),)})
    assert found.keys() == columns.keys()
    assert found["z"][0] == 7.0
    assert found["gyro_z"][0] == 1.0


def test_a_column_map_names_only_columns_that_are_there(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    _write_csv(_vectors("cf1_"), tmp_path / "flight.csv")
    (tmp_path / "cf1_00").write_bytes(_log_of_a_line())
    (tmp_path / "map.yaml").write_text("columns: {vx: stateEstimate.vx_typo, y: xx}")
    for file, message in (
        ("flight.csv", "vx of the column map: there is no stateEstimate.vx_typo; known are cf1_x, cf1_y"),
        ("cf1_00", "there is no stateEstimate.vx_typo; did you mean stateEstimate."),
    ):
        given = [str(tmp_path / file), "--columns", str(tmp_path / "map.yaml")]
        assert main([*given, "--out", str(tmp_path / "bag")]) == 1
        assert message in capsys.readouterr().err


def test_a_log_goes_into_a_bag_under_its_files_name(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    for name in ("cf7_03", "cf8_03"):
        (tmp_path / name).write_bytes(_log_of_a_line())
    logs = [str(tmp_path / name) for name in ("cf7_03", "cf8_03")]
    assert main([*logs, "--out", str(tmp_path / "bag")]) == 0
    assert "  clocks count from the start of logging: taken as common" in capsys.readouterr().out
    flight = read_flight(tmp_path / "bag")
    assert flight.names == ("cf7", "cf8")
    np.testing.assert_allclose(flight.mocap_pos[:, 1, 0], flight.t, atol=1e-6)
    assert main([*logs, "--names", "cf7,cf7", "--out", str(tmp_path / "other")]) == 1
    assert "give --names, a different one each" in capsys.readouterr().err


def test_vehicles_switched_on_at_their_own_times_begin_together(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    for name, first_us in (("cf7_03", 35_200_000), ("cf8_03", 35_800_000)):
        (tmp_path / name).write_bytes(_log_of_a_line(first_us))
    logs = [str(tmp_path / name) for name in ("cf7_03", "cf8_03")]
    assert main([*logs, "--out", str(tmp_path / "bag")]) == 0
    told = "clocks count from switching on: all first rows are taken as one time (cf7 35.200 s, cf8 35.800 s)"
    assert told in capsys.readouterr().out
    flight = read_flight(tmp_path / "bag")
    np.testing.assert_allclose(flight.mocap_pos[:, 0], flight.mocap_pos[:, 1], atol=1e-6)
