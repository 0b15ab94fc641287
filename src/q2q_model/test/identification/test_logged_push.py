"""The force in a log is read by its mass, and one of another unit or sign is refused or reported."""

from dataclasses import replace

import numpy as np
import pytest
from made_flights import GRAVITY, Pass, made_flight

from q2q_model.downwash.jet import MEASURED_LAW
from q2q_model.flights.flight_log import FlightLog
from q2q_model.identification.push.log_check import log_notes
from q2q_model.identification.push.log_column_note import log_column_notes
from q2q_model.identification.push.recorded_push import push_of_sensors, push_record
from q2q_model.recordings.flight_recording import Recording
from q2q_model.signals.values import Array
from q2q_model.vehicle.altitude_loop import AltitudeLoop
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, CRAZYFLIE_BRUSHLESS, Vehicle

PASS = Pass(law=MEASURED_LAW, loop=AltitudeLoop(10.0, 5.0, lag=CRAZYFLIE_2_0.thrust_lag), speed=0.1)
COLUMNS = ("faz_est", "thrust_est", "gap", "pwm1", "pwm2", "pwm3", "pwm4")


def logged(mass: float, scale: float = 1.0, vehicle: Vehicle = CRAZYFLIE_2_0) -> Recording:
    """Return a flight of `vehicle` whose log has its downwash as a force of a `mass` [kg], times `scale`."""
    flight = made_flight(PASS)
    eta, felt = flight.true_eta[..., 2], flight.specific_force_body[..., 2]
    zero, half = np.zeros_like(eta), np.full_like(eta, 0.5)
    values = np.stack([scale * mass * eta, mass * (felt - eta), zero, half, half, half, half], axis=-1)
    flight = replace(flight, thrust=flight.thrust * vehicle.mass / CRAZYFLIE_2_0.mass)
    return Recording(flight, FlightLog(flight.t, flight.names, COLUMNS, ("",) * len(COLUMNS), values))


def without_thrust(one: Recording) -> Recording:
    """Return a recording without thrust_est in its log."""
    assert one.log is not None
    kept = [k for k, name in enumerate(COLUMNS) if name != "thrust_est"]
    names = tuple(COLUMNS[k] for k in kept)
    log = replace(one.log, columns=names, units=("",) * len(names), values=one.log.values[..., kept])
    return replace(one, log=log)


@pytest.mark.parametrize("mass", [0.032, 0.0326, 0.045])
def test_a_logs_thrust_shows_the_mass_of_its_force(mass: float) -> None:
    record = push_record(logged(mass), CRAZYFLIE_2_0, CRAZYFLIE_2_0.thrust_lag)
    assert record is not None
    np.testing.assert_allclose(record.push, made_flight(PASS).true_eta[..., 2], atol=1e-12)
    assert log_column_notes([logged(mass)], CRAZYFLIE_2_0) == []


def test_a_thrust_that_shows_no_mass_or_an_impossible_one_is_reported() -> None:
    whole = logged(0.032)
    assert whole.log is not None
    gram = 1e-3 * GRAVITY
    grams = whole.log.values / np.where(np.array(COLUMNS) == "thrust_est", gram, 1.0)
    in_grams = replace(whole, log=replace(whole.log, values=grams))
    felt = whole.flight.specific_force_body
    in_g, unfelt = (
        replace(whole, flight=replace(whole.flight, specific_force_body=scale * felt))
        for scale in (1.0 / GRAVITY, np.nan)
    )
    assert log_column_notes([without_thrust(whole)], CRAZYFLIE_2_0) == []
    (unknown,) = log_column_notes([whole, unfelt], CRAZYFLIE_2_0)
    assert "of cf1, cf2 in 1 flight is unknown: faz_est is divided by the 34 g of crazyflie_2_0" in unknown
    (far,) = log_column_notes([in_grams], CRAZYFLIE_2_0)
    assert "of cf1, cf2 in 1 flight is 3.26 kg, expected 0.5 to 2 times the mass of crazyflie_2_0" in far
    again = replace(in_g, flight=replace(in_g.flight, name="again"))
    (near,) = log_column_notes([in_g, again], CRAZYFLIE_2_0)
    assert "of cf1, cf2 in 2 flights is 0.314 kg" in near


def with_column(one: Recording, column: str, vehicle: int, values: float | Array) -> Recording:
    """Return a recording whose log has other values in a column of a vehicle."""
    assert one.log is not None
    changed = one.log.values.copy()
    changed[:, vehicle, COLUMNS.index(column)] = values
    return replace(one, log=replace(one.log, values=changed))


def test_each_vehicles_mass_is_that_of_its_own_rows() -> None:
    """Of 32 and 48 g, the lower one's downwash is not divided by what the other shows."""
    light, heavy = (logged(mass).log for mass in (0.032, 0.048))
    assert light is not None
    assert heavy is not None
    one = replace(logged(0.032), log=replace(light, values=light.values.copy()))
    assert one.log is not None
    one.log.values[:, 1] = heavy.values[:, 1]
    record = push_record(one, CRAZYFLIE_2_0, CRAZYFLIE_2_0.thrust_lag)
    assert record is not None
    np.testing.assert_allclose(record.push, made_flight(PASS).true_eta[..., 2], atol=1e-12)
    assert log_column_notes([one], CRAZYFLIE_2_0) == []


def test_a_vehicle_that_shows_no_mass_has_that_of_its_type_and_is_named() -> None:
    one = with_column(logged(0.048), "thrust_est", 0, np.nan)
    record = push_record(one, CRAZYFLIE_2_0, CRAZYFLIE_2_0.thrust_lag)
    assert record is not None
    scale = np.array([0.048 / CRAZYFLIE_2_0.mass, 1.0])
    np.testing.assert_allclose(record.push, scale * made_flight(PASS).true_eta[..., 2], atol=1e-12)
    (unknown,) = log_column_notes([one], CRAZYFLIE_2_0)
    assert "of cf1 in 1 flight is unknown: faz_est is divided by the 34 g of crazyflie_2_0" in unknown


def test_a_vehicle_without_a_force_in_the_log_has_the_push_of_its_sensors_and_is_named() -> None:
    one = with_column(with_column(logged(0.032), "faz_est", 1, np.nan), "thrust_est", 1, np.nan)
    one = with_column(one, "gap", 1, np.arange(one.flight.t.size) == 3)
    whole, lacking = (push_record(each, CRAZYFLIE_2_0, 0.07) for each in (logged(0.032), one))
    sensed = push_of_sensors(one.flight, CRAZYFLIE_2_0, 0.07)
    assert whole is not None
    assert lacking is not None
    assert sensed is not None
    np.testing.assert_array_equal(lacking.push[:, 0], whole.push[:, 0])
    np.testing.assert_array_equal(lacking.push[:, 1], sensed.push[:, 1])
    assert np.argwhere(~lacking.measured).tolist() == [[3, 1]]
    assert log_column_notes([one], CRAZYFLIE_2_0) == [
        "pass: no faz_est of cf2 in the log: push from imu and command, with a thrust lag of 0.07 s"
    ]
    felt = one.flight.specific_force_body.copy()
    felt[:, 1] = np.nan
    unfelt = replace(one, flight=replace(one.flight, specific_force_body=felt))
    assert log_column_notes([unfelt], CRAZYFLIE_2_0) == [
        "pass: no faz_est, or imu and command, of cf2 in the log: no push is known on it, or near it"
    ]


def test_a_vehicle_without_gaps_in_the_log_has_none_and_is_named() -> None:
    one = with_column(logged(0.032), "gap", 0, np.nan)
    record = push_record(one, CRAZYFLIE_2_0, CRAZYFLIE_2_0.thrust_lag)
    assert record is not None
    assert record.measured.all()
    assert log_column_notes([one], CRAZYFLIE_2_0) == [
        "pass: no gap of cf1 in the log: all its rows count as measured"
    ]


def test_without_it_the_mass_is_that_of_the_vehicle() -> None:
    vehicle = CRAZYFLIE_BRUSHLESS
    record = push_record(without_thrust(logged(vehicle.mass, vehicle=vehicle)), vehicle, vehicle.thrust_lag)
    assert record is not None
    np.testing.assert_allclose(record.push, made_flight(PASS).true_eta[..., 2], atol=1e-12)


def test_a_force_in_grams_is_refused_with_its_flight_vehicle_and_unit() -> None:
    """The vehicle is under the other in more than 5 % of the time."""
    gram = 1e-3 * GRAVITY
    says = (
        r"flight pass: faz_est of cf1 varies by .* N, .* weight of crazyflie_2_0; must be at most .* newtons"
    )
    with pytest.raises(ValueError, match=says):
        push_record(logged(0.032, 1.0 / gram), CRAZYFLIE_2_0, CRAZYFLIE_2_0.thrust_lag)


def test_a_logged_force_is_compared_with_accelerometer_and_command() -> None:
    assert log_notes([logged(0.032)], CRAZYFLIE_2_0) == []
    (upside_down,) = log_notes([logged(0.032, -1.0)], CRAZYFLIE_2_0)
    assert "is -1.0" in upside_down
    assert "positive upwards" in upside_down
    (small,) = log_notes([logged(0.032, 0.1)], CRAZYFLIE_2_0)
    assert "is 0.10 times what accelerometer and command show, expected 0.25 to 2" in small


def test_a_duty_at_the_limit_is_saturated_in_single_precision_as_in_double() -> None:
    one = logged(0.032)
    assert one.log is not None
    duties = [0.93, float(np.float32(0.93)), 0.929]  # a log in thousandths
    values = one.log.values.copy()
    values[: len(duties), 0, COLUMNS.index("pwm3")] = duties
    record = push_record(
        replace(one, log=replace(one.log, values=values)), CRAZYFLIE_2_0, CRAZYFLIE_2_0.thrust_lag
    )
    assert record is not None
    assert record.saturated[:, 0].nonzero()[0].tolist() == [0, 1]
