"""Pushes from recorded commands and logs: a weight that fits, and motors at their limit."""

import re
from dataclasses import replace

import numpy as np
import pytest
from made_flights import Pass, made_flight

from q2q_model.flights.flight_log import FlightLog
from q2q_model.identification.push.log_mass import LOG_MASS
from q2q_model.identification.push.recorded_push import check_weight, motion_of, push_of_log
from q2q_model.signals.values import Mask
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, CRAZYFLIE_2_1, TEXTBOOK_065


def test_commands_that_do_not_carry_the_vehicle_are_refused_with_the_remedy() -> None:
    flight = made_flight(Pass())
    check_weight(flight, CRAZYFLIE_2_0)
    check_weight(flight, CRAZYFLIE_2_1)  # 27 g, not 34
    check_weight(
        replace(flight, thrust=np.full_like(flight.thrust, np.nan)), TEXTBOOK_065
    )  # nothing to judge
    waits = np.where(flight.t[:, None] < 20.0, 0.0, 1.0)  # two thirds of the flight on the ground
    pos = flight.pos * waits[..., None]
    check_weight(replace(flight, pos=pos, thrust=flight.thrust * waits), CRAZYFLIE_2_0)
    with pytest.raises(ValueError, match=r"0\.0523 times the weight of textbook_065.*with --vehicle"):
        check_weight(flight, TEXTBOOK_065)
    pwm = replace(flight, thrust=flight.thrust / CRAZYFLIE_2_0.full_pwm_thrust * 65535.0)
    with pytest.raises(
        ValueError, match=r"flight pass: the median thrust of cf1 .*record commands in newtons"
    ):
        check_weight(pwm, CRAZYFLIE_2_0)


DUTIES = ("faz_est", "gap", "pwm1", "pwm2", "pwm3", "pwm4")
SATURATED = range(100, 120)
"""Rows in which a motor of cf1 is at 0.95."""


def motors(full: float) -> FlightLog:
    """Return a log of motors at half of a full duty, but for one in SATURATED."""
    flight = made_flight(Pass())
    values = np.full((flight.t.size, 2, 6), 0.5)
    values[..., 1] = 0.0
    values[SATURATED, 0, 4] = 0.95
    values[..., 2:] *= full
    return FlightLog(flight.t, flight.names, DUTIES, ("",) * 6, values)


def saturated(log: FlightLog) -> Mask:
    """Return where a log's motors are saturated, (T, n)."""
    return push_of_log("made", log, motion_of(made_flight(Pass())), LOG_MASS).saturated


def test_motors_logged_as_pwm_saturate_where_those_logged_as_duty_do() -> None:
    found = saturated(motors(1.0))
    assert np.flatnonzero(found[:, 0]).tolist() == list(SATURATED)
    assert not found[:, 1].any()
    np.testing.assert_array_equal(saturated(motors(65535.0)), found)


@pytest.mark.parametrize(("full", "wrong"), [(1.0, 1.00002), (1.0, 40.0), (65535.0, 0.9), (65535.0, 1e6)])
def test_one_wrong_value_does_not_change_the_scale_of_motors(full: float, wrong: float) -> None:
    log = motors(full)
    right = saturated(log)
    log.values[50, 0, 3] = wrong
    right[50, 0] = wrong > 0.95 * full
    np.testing.assert_array_equal(saturated(log), right)


def test_each_vehicle_has_its_own_scale_of_motors() -> None:
    log = motors(1.0)
    log.values[:, 1, 2:] *= 65535.0
    np.testing.assert_array_equal(saturated(log), saturated(motors(1.0)))


@pytest.mark.parametrize("full", [100.0, 255.0, 2000.0, 1e6])
def test_motors_of_another_scale_are_refused_with_the_remedy(full: float) -> None:
    message = f"flight made: pwm1 to pwm4 of cf1 are {0.5 * full:.4g} in the median and reach "
    with pytest.raises(ValueError, match=re.escape(message) + r".*0 to 65535.*\(bag_import --columns\)"):
        saturated(motors(full))
