"""What Crazyswarm2's server reports of a vehicle, what crazyflies.yaml sets: known, old, never reported."""

import math

import pytest

from q2q_control.crazyswarm.reported_vehicles import ARM_S, READ_S, ReportedVehicles
from q2q_control.crazyswarm.server_vehicle import ServerVehicle
from q2q_control.flight_procedure.supervisor_info import ARMED, CAN_FLY, FLYING, LOCKED, READY
from q2q_control.radio.crazyflies_file import params_set
from q2q_model.vehicle.constants import vehicle_by_name
from q2q_model.vehicle.hover_thrust import OwnHover, hover_ratio

VEHICLE = vehicle_by_name("crazyflie_2_0", "stock")
WANTED = {"stabilizer.controller": 2.0}
REPORTED = {"stabilizer.controller": 2.0, "ctrlMel.mass": 0.027, "ctrlMel.massThrust": 132000.0}
DOCUMENT = {
    "robots": {
        "cf1": {"type": "cf21", "firmware_params": {"ctrlMel": {"mass": 0.041}}},
        "cf2": {"type": "cf21"},
    },
    "robot_types": {"cf21": {"firmware_params": {"ctrlMel": {"mass": 0.035, "massThrust": 130000}}}},
    "all": {"firmware_params": {"stabilizer": {"controller": 2}, "ctrlMel": {"mass": 0.03}}},
}


def vehicle(**file: float) -> ServerVehicle:
    return ServerVehicle("cf1", VEHICLE, WANTED, {name.replace("__", "."): v for name, v in file.items()})


def test_nothing_reported_is_known_of_nothing() -> None:
    report = vehicle().report(0.0, connected=True)
    assert (report.wrong, report.onboard, report.armed) == (None, None, None)
    assert math.isnan(report.volt)
    assert math.isnan(report.hover_ratio)


def test_a_vehicle_is_in_the_air_by_its_newest_status_and_unknown_by_a_stale_one() -> None:
    one = vehicle()
    for info, airborne in ((READY, False), (READY | FLYING, True)):
        one.take_status(4.0, info, 10.0)
        assert one.report(12.9, connected=True).airborne is airborne
    assert one.report(13.1, connected=True).airborne is None


def test_a_vehicle_is_silent_since_a_setpoint_was_last_sent_to_it() -> None:
    one = vehicle()
    assert one.report(5.0, connected=True).silent_s == math.inf
    one.take_sent(5.0)
    assert one.report(5.5, connected=True).silent_s == 0.5


def test_parameters_of_the_file_count_more_than_those_that_the_server_read_before_it_set_them() -> None:
    one = vehicle(ctrlMel__mass=0.041)
    one.take_parameters(REPORTED)
    expected = hover_ratio(VEHICLE, OwnHover(mass=0.041, mass_thrust=132000.0))
    assert one.report(0.0, connected=True).hover_ratio == expected


def test_an_answer_without_values_forgets_the_last() -> None:
    one = vehicle()
    one.take_parameters({**REPORTED, "stabilizer.controller": 1.0})
    assert one.report(0.0, connected=True).wrong == (
        "its stabilizer.controller is 1, expected 2 (firmware_params)"
    )
    one.take_parameters({})
    report = one.report(0.0, connected=True)
    assert report.wrong is None
    assert math.isnan(report.hover_ratio)


@pytest.mark.parametrize(("held", "wrong"), [(2.0, ""), (6.0, ""), (5.0, "is 5, expected 2"), (1.0, "is 1,")])
def test_full_states_are_for_mellingers_controller_and_for_that_of_the_firmware_app(
    held: float, wrong: str
) -> None:
    one = vehicle()
    one.take_parameters({**REPORTED, "stabilizer.controller": held})
    message = one.report(0.0, connected=True).wrong
    assert message == "" if wrong == "" else wrong in (message or "")


def test_an_estimate_of_another_shape_or_age_is_none() -> None:
    one = vehicle()
    one.take_estimate([1.0, 2.0, 3.0], 0.0)
    assert one.report(2.9, connected=True).onboard == (1.0, 2.0, 3.0)
    assert all(math.isnan(part) for part in one.report(3.1, connected=True).onboard)
    one.take_estimate([1.0, 2.0], 3.2)
    assert all(math.isnan(part) for part in one.report(3.2, connected=True).onboard)


def test_armed_is_only_what_was_told_after_it_was_asked() -> None:
    one = vehicle()
    assert one.armed_since(0.0) is None
    one.take_status(4.0, READY, 1.0)
    assert one.armed_since(0.5) is True
    assert one.armed_since(1.0) is False
    one.take_status(4.0, 0, 2.0)
    assert one.armed_since(1.0) is False


@pytest.mark.parametrize(
    ("name", "by_type", "mass", "mass_thrust"),
    [("cf1", True, 0.041, 130000.0), ("cf2", True, 0.035, 130000.0), ("cf2", False, 0.03, None)],
)
def test_a_robots_parameters_go_before_its_types_and_those_before_the_ones_of_all(
    name: str, by_type: bool, mass: float, mass_thrust: float | None
) -> None:
    found = params_set(DOCUMENT, name, by_type=by_type)
    assert found["stabilizer.controller"] == 2.0
    assert (found["ctrlMel.mass"], found.get("ctrlMel.massThrust")) == (mass, mass_thrust)


def test_a_number_beyond_all_floats_is_one_that_no_vehicle_can_hold() -> None:
    values = {"robots": {"cf1": {"firmware_params": {"a": {"b": 10**400, "c": -(10**400)}}}}}
    assert params_set(values, "cf1", by_type=True) == {"a.b": math.inf, "a.c": -math.inf}


def test_each_vehicle_has_armed_by_its_status_or_after_a_time_if_it_reports_none() -> None:
    one, other = vehicle(), vehicle()
    both = ReportedVehicles((one, other))
    assert not both.armed(10.0, 10.0 + 0.9 * ARM_S)
    assert both.armed(10.0, 10.0 + 1.1 * ARM_S)
    for unready in (LOCKED, ARMED, CAN_FLY):
        one.take_status(4.0, unready, 10.1)
        assert not both.armed(10.0, 10.0 + 1.1 * ARM_S)
        assert one.report(10.2, connected=True).armed is False
    one.take_status(4.0, READY, 10.1)
    other.take_status(4.0, READY, 9.9)  # before the order
    assert not both.armed(10.0, 10.0 + 1.1 * ARM_S)
    other.take_status(4.0, READY | FLYING, 10.2)
    assert both.armed(10.0, 10.3)
    assert other.report(10.3, connected=True).armed is True


def test_parameters_are_read_once_a_period() -> None:
    both = ReportedVehicles((vehicle(),))
    assert [both.poll_read(t) for t in (5.0, 5.0 + 0.5 * READ_S, 5.0 + READ_S)] == [True, False, True]
