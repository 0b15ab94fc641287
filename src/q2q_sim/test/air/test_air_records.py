"""Records of flights for an air: a row with a lost value is a gap, not the end of every number."""

from dataclasses import replace

import numpy as np
import pytest
from synthetic_air import Wake, orbit, wide_jet
from synthetic_air import flown as flown_under

from q2q_model.recordings.flight_recording import Recording
from q2q_model.recordings.recording_reader import recording_of_table
from q2q_model.vehicle.constants import CRAZYFLIE_2_0
from q2q_sim.air.learning.edge_torque_term import edge_torque_term
from q2q_sim.air.learning.lateral_push import lateral_push
from q2q_sim.air.learning.rate_load_term import rate_load_term
from q2q_sim.air.learning.records.air_record import AirRecord, Motors, air_records
from q2q_sim.air.learning.rotor_drag_term import rotor_drag_term
from q2q_sim.air.learning.vehicle_term import vehicle_term

ROWS, LOST = 600, 300
PLACES = {"cf1": (0.0, 0.6), "cf2": (1.0, 0.9)}
"""x and z of two vehicles in clear air [m]."""
CONSTANT = {"qw": 1.0, "thrust_cmd": 0.33, "vbat": 3.7} | {f"pwm{k}": 0.65 for k in range(1, 5)}
RISING = ("thrust_est", "ax", "wq", "faz_est")
"""Columns that rise evenly, so that a value between two is known."""
AT_REST = ("y", "vx", "vy", "vz", "ay", "az", "qx", "qy", "qz", "wp", "wr", "gap")


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    """Return a flight of two vehicles without a gap."""
    columns = {"t": 0.01 * np.arange(1, ROWS + 1)}
    for name, (x, z) in PLACES.items():
        values = {"x": x, "z": z} | CONSTANT | dict.fromkeys(AT_REST, 0.0)
        columns |= {f"{name}_{key}": np.full(ROWS, value) for key, value in values.items()}
        columns |= {f"{name}_{key}": 0.3 + 1e-4 * np.arange(ROWS) for key in RISING}
    path = tmp_path_factory.mktemp("air") / "pair.csv"
    table = np.stack(list(columns.values()), axis=1)
    np.savetxt(path, table, delimiter=",", header=",".join(columns), comments="", fmt="%.17g")
    return recording_of_table(path)


def without(flown: Recording, what: str, rows: slice) -> Recording:
    """Return the flight without a column of its log, or an array of its flight, of the first vehicle."""
    if flown.log is not None and what in flown.log.columns:
        values = flown.log.values.copy()
        values[rows, 0, flown.log.columns.index(what)] = np.nan
        return replace(flown, log=replace(flown.log, values=values))
    values = getattr(flown.flight, what).copy()
    values[rows, 0] = np.nan
    return replace(flown, flight=replace(flown.flight, **{what: values}))


def record_of(flown: Recording) -> AirRecord:
    """Return the record of one flight."""
    (record,), _ = air_records([flown], CRAZYFLIE_2_0, CRAZYFLIE_2_0.thrust_lag)
    return record


@pytest.mark.parametrize("lost", ["thrust_est", "faz_est", "gap", "specific_force_body", "gyro_body", "quat"])
def test_a_row_with_a_lost_value_is_a_gap_and_changes_no_other(flown: Recording, lost: str) -> None:
    whole, record = record_of(flown), record_of(without(flown, lost, slice(LOST, LOST + 1)))
    known = np.arange(ROWS) != LOST
    assert whole.measured.all()
    assert (record.measured == known[:, None]).all()
    np.testing.assert_allclose(record.thrust, whole.thrust, rtol=1e-12)
    np.testing.assert_allclose(record.rate_body, whole.rate_body, rtol=1e-12)
    np.testing.assert_allclose(record.specific_force[known], whole.specific_force[known], rtol=1e-12)
    np.testing.assert_allclose(
        record.thrust_ratio, whole.thrust_ratio, rtol=1e-3
    )  # the median is of a row less


def test_a_vehicle_whose_thrust_is_never_logged_has_that_of_its_command(flown: Recording) -> None:
    whole = record_of(flown)
    for lost in (flown, without(flown, "faz_est", slice(None))):  # the push, too, is then that of sensors
        record = record_of(without(lost, "thrust_est", slice(None)))
        assert record.measured.all()
        np.testing.assert_allclose(record.thrust[:, 0], CONSTANT["thrust_cmd"], rtol=1e-12)
        np.testing.assert_array_equal(record.thrust[:, 1], whole.thrust[:, 1])


def test_of_a_vehicle_whose_thrust_is_never_known_nothing_is_measured(flown: Recording) -> None:
    record = record_of(without(without(flown, "thrust_est", slice(None)), "thrust", slice(None)))
    assert not record.measured[:, 0].any()
    assert record.measured[:, 1].all()  # 1 m away
    assert np.isfinite(record.thrust_ratio[:, 1]).all()


def test_a_flight_without_any_thrust_is_left_out_with_the_column_that_it_lacks(flown: Recording) -> None:
    assert flown.log is not None
    shown = np.array(flown.log.columns) != "thrust_est"
    log = replace(flown.log, values=np.where(shown, flown.log.values, np.nan))
    flight = replace(flown.flight, thrust=np.full_like(flown.flight.thrust, np.nan))
    records, notes = air_records([Recording(flight, log)], CRAZYFLIE_2_0, CRAZYFLIE_2_0.thrust_lag)
    assert not records
    assert notes[-1] == (
        "pair has no thrust, to which a jet is proportional: record command, or thrust_est beside faz_est"
    )


def test_a_log_slower_than_that_of_the_force_is_told(flown: Recording) -> None:
    slow = without(flown, "specific_force_body", slice(None, None, 2))
    (record,), notes = air_records([slow], CRAZYFLIE_2_0, CRAZYFLIE_2_0.thrust_lag)
    assert record.measured[:, 0].mean() == 0.5
    assert notes == ["pair: rows without thrust, acceleration or rates are gaps: 50% of cf1"]
    assert not air_records([flown], CRAZYFLIE_2_0, CRAZYFLIE_2_0.thrust_lag)[1]


def test_a_flight_without_an_accelerometer_is_measured_by_its_log(flown: Recording) -> None:
    assert record_of(without(flown, "specific_force_body", slice(None))).measured.all()


@pytest.fixture(scope="module")
def felt() -> list[AirRecord]:
    """Return flights under the wide jet with motors, accelerations, rates and attitudes."""
    shape = (3000, 2)
    motors = Motors(np.full((*shape, 4), 0.65), np.full(shape, 3.7))
    made = [flown_under(f"pair{k}", orbit(30.0, (0.6, 1.0), k), Wake(wide_jet()), k) for k in range(6)]
    return [replace(one, motors=motors) for one in made]


def test_terms_of_accelerations_and_rates_are_not_learned_without_them(felt: list[AirRecord]) -> None:
    jet = wide_jet()
    blind = [
        replace(one, specific_force=one.specific_force * np.nan, rate_body=one.rate_body * np.nan)
        for one in felt
    ]
    for records, known in ((felt, True), (blind, False)):
        found = (
            edge_torque_term(records, jet, CRAZYFLIE_2_0),
            lateral_push(records, jet),
            rotor_drag_term(records),
            vehicle_term(records, CRAZYFLIE_2_0),
        )
        assert [one is not None for one in found] == [known] * 4
    assert rate_load_term(blind, CRAZYFLIE_2_0) is None


def test_the_edge_torque_is_learned_from_the_rows_with_an_attitude(felt: list[AirRecord]) -> None:
    jet, half = wide_jet(), felt[0].quat.shape[0] // 2
    lost = [replace(one, quat=one.quat.copy()) for one in felt]
    for one in lost:
        one.quat[:half] = np.nan
    whole, part = (edge_torque_term(records, jet, CRAZYFLIE_2_0) for records in (felt, lost))
    assert whole is not None
    assert part is not None
    assert 0 < (part.values[0].rows or 0) < (whole.values[0].rows or 0)
    assert np.isfinite(part.term.peak_nm)
    nowhere = [replace(one, quat=one.quat * np.nan) for one in felt]
    assert edge_torque_term(nowhere, jet, CRAZYFLIE_2_0) is None
