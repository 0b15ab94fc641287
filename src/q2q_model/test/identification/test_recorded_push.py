"""Pushes from recorded commands and logs: a weight that fits, and motors at their limit."""

from dataclasses import replace

import numpy as np
import pytest
from made_flights import Pass, made_flight

from q2q_model.flights.flight_log import FlightLog
from q2q_model.identification.push.recorded_push import LOG_MASS, check_weight, motion_of, push_of_log
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


def test_motors_logged_as_pwm_saturate_where_those_logged_as_duty_do() -> None:
    flight = made_flight(Pass())
    columns = ("faz_est", "gap", "pwm1", "pwm2", "pwm3", "pwm4")
    values = np.full((flight.t.size, 2, 6), 0.5)
    values[..., 1] = 0.0
    values[100:120, 0, 4] = 0.95
    found = []
    for full in (1.0, 65535.0):
        scaled = values * np.array([1.0, 1.0, full, full, full, full])
        log = FlightLog(flight.t, flight.names, columns, ("",) * 6, scaled)
        found.append(push_of_log("made", log, motion_of(flight), LOG_MASS).saturated)
    assert np.flatnonzero(found[0][:, 0]).tolist() == list(range(100, 120))
    assert not found[0][:, 1].any()
    np.testing.assert_array_equal(*found)
