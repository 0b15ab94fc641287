"""Tables of flights with some columns only: what a signal can hold is in it, the rest is in the log."""

import numpy as np
import pytest

from q2q_model.flights.flight import Flight
from q2q_model.flights.joined_flight import flight_from_signals
from q2q_model.flights.tables.column_map import SourceColumn, mapped_table
from q2q_model.flights.tables.flight_table import ANGLES, EULER, QUAT, RATE, FlightTable, flight_table
from q2q_model.flights.tables.table_log import log_of
from q2q_model.flights.tables.table_signals import signals_of
from q2q_model.geometry.rotations import quat_from_euler, rotate
from q2q_model.signals.values import Array, SwarmState
from q2q_model.vehicle.constants import GRAVITY

TICKS = 50
TURN = (0.1, -0.2, 0.3)
"""Roll, pitch and yaw of the table [rad]."""
ATTITUDE = (*QUAT, *EULER)
WHOLE = ("x", "y", "z", "vx", "vy", "vz", "ax", "ay", "az", *RATE, *ATTITUDE)


def _columns(*without: str) -> dict[str, Array]:
    """Return a table of cf1 and cf2, whose attitudes are TURN, without some columns."""
    rng = np.random.default_rng(3)
    columns: dict[str, Array] = {f"cf{k}_{name}": rng.normal(size=TICKS) for k in (1, 2) for name in WHOLE}
    attitude = (*quat_from_euler(*TURN), *TURN)
    columns |= {
        f"cf{k}_{name}": np.full(TICKS, value)
        for k in (1, 2)
        for name, value in zip(ATTITUDE, attitude, strict=True)
    }
    lacking = {f"cf{k}_{name}" for k in (1, 2) for name in without}
    kept = {name: values for name, values in columns.items() if name not in lacking}
    return kept | {"t": np.arange(TICKS) / 100.0}


def _flight(table: FlightTable) -> Flight:
    signals = {topic.removeprefix("/"): list(rows) for topic, rows in signals_of(table).items()}
    return flight_from_signals("flight", signals).flight


def test_without_rates_velocities_and_accelerations_stay_and_rates_are_not_numbers() -> None:
    table = flight_table(_columns(*RATE))
    flight = _flight(table)
    for k, axis in enumerate("xyz"):
        np.testing.assert_array_equal(flight.vel[..., k], table.columns[f"v{axis}"])
    acc = rotate(flight.quat, flight.specific_force_body) - [0.0, 0.0, GRAVITY]
    np.testing.assert_allclose(acc, table.vectors(("ax", "ay", "az")), atol=1e-13)  # near 10, turned twice
    assert np.isnan(flight.gyro_body).all()
    states = [one for one in signals_of(table)["/state"] if isinstance(one, SwarmState)]
    assert np.isnan([one.ang_vel_body for one in states]).all()
    assert log_of(table).columns == ()


@pytest.mark.parametrize("empty", [("vx", "vy", "vz"), ("ax", "ay", "az"), RATE, QUAT, ("vy",)])
def test_empty_columns_are_as_absent_ones(empty: tuple[str, ...]) -> None:
    given = _columns()
    given |= {f"cf{k}_{name}": np.full(TICKS, np.nan) for k in (1, 2) for name in empty}
    table, lacking = flight_table(given), flight_table(_columns(*empty))
    assert set(signals_of(table)) == set(signals_of(lacking))
    assert log_of(table).columns == log_of(lacking).columns


def test_angles_in_radians_by_their_name_are_the_attitude_where_no_quaternion_is() -> None:
    flight = _flight(flight_table(_columns(*QUAT)))
    whole = _flight(flight_table(_columns()))
    np.testing.assert_allclose(flight.quat, whole.quat, atol=1e-15)
    np.testing.assert_allclose(flight.mocap_quat, whole.mocap_quat, atol=1e-15)
    np.testing.assert_allclose(flight.specific_force_body, whole.specific_force_body, atol=1e-14)


def test_a_vehicle_with_angles_beside_one_with_a_quaternion_has_its_attitude() -> None:
    columns = {name: one for name, one in _columns().items() if name not in {f"cf2_{part}" for part in QUAT}}
    flight = _flight(flight_table(columns))
    np.testing.assert_allclose(flight.quat, _flight(flight_table(_columns())).quat, atol=1e-15)


@pytest.mark.parametrize(
    ("without", "logged"),
    [
        (ATTITUDE, (*("vx", "vy", "vz", "ax", "ay", "az"), *RATE)),
        (
            ("qw", "yaw_rad"),
            (*("vx", "vy", "vz", "ax", "ay", "az"), *RATE, "qx", "qy", "qz", "roll_rad", "pitch_rad"),
        ),
        (("vy", "az"), ("vx", "vz", "ax", "ay", *RATE)),
        (("wq",), ("wp", "wr")),
    ],
)
def test_what_no_signal_holds_is_in_the_log(without: tuple[str, ...], logged: tuple[str, ...]) -> None:
    columns = _columns(*without)
    log = log_of(flight_table(columns))
    assert log.columns == logged
    for name in logged:
        np.testing.assert_array_equal(log.column(name)[:, 1], columns[f"cf2_{name}"])


def test_what_a_vehicle_has_without_an_attitude_beside_one_with_one_is_in_the_log() -> None:
    plain = {f"cf{k}_{name}": np.full(TICKS, 0.5) for k in (1, 2) for name in ANGLES}
    columns = _columns() | plain
    lacking = {f"cf2_{name}" for name in ATTITUDE}
    table = flight_table({name: one for name, one in columns.items() if name not in lacking})
    log = log_of(table)
    assert log.columns == ("ax", "ay", "az", *ANGLES)
    np.testing.assert_array_equal(log.column("az")[:, 1], columns["cf2_az"])
    np.testing.assert_array_equal(_flight(table).vel[:, 1, 2], columns["cf2_vz"])
    unseen = {f"cf1_{name}": np.full(TICKS, np.nan) for name in ATTITUDE}
    assert {"ax", "ay", "az"} < set(log_of(flight_table(columns | unseen)).columns)


def test_references_and_thrust_that_are_in_part_are_in_the_log() -> None:
    rest = ("xref", "vxref", "yawref_deg")
    columns = _columns() | {f"cf1_{name}": np.ones(TICKS) for name in rest}
    assert log_of(flight_table(columns)).columns == rest


def test_angles_in_degrees_are_refused_where_they_are_the_attitude() -> None:
    degrees = {"cf1_roll_rad": np.full(TICKS, 6.0)}
    with pytest.raises(
        ValueError, match=r"roll_rad and pitch_rad of cf1 reach 6; must be in radians: .* 0\.0174533"
    ):
        flight_table(_columns(*QUAT) | degrees)
    flight_table(_columns() | degrees)


def test_angles_of_unknown_unit_are_no_attitude() -> None:
    plain = {f"cf{k}_{name}": np.full(TICKS, 0.5) for k in (1, 2) for name in ANGLES}
    table = flight_table(_columns(*ATTITUDE) | plain)
    assert np.isnan(_flight(table).mocap_quat).all()
    assert set(ANGLES) < set(log_of(table).columns)
    assert log_of(table).units[log_of(table).columns.index("roll")] == ""
    assert not set(ANGLES) & set(log_of(flight_table(_columns() | plain)).columns)  # beside an attitude


def test_a_column_map_makes_degrees_of_the_firmware_the_attitude() -> None:
    theirs = dict(zip(ANGLES, np.rad2deg(TURN) * [1.0, -1.0, 1.0], strict=True))  # pitch nose up
    plain = {f"cf{k}_{name}": np.full(TICKS, angle) for k in (1, 2) for name, angle in theirs.items()}
    scales = zip(ANGLES, EULER, np.deg2rad([1.0, -1.0, 1.0]), strict=True)
    chosen = {ours: (SourceColumn(name, float(scale)),) for name, ours, scale in scales}
    table = flight_table(mapped_table(_columns(*ATTITUDE) | plain, chosen))
    np.testing.assert_allclose(_flight(table).quat, _flight(flight_table(_columns())).quat, atol=1e-15)
