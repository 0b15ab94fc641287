"""An online refinement reports a vehicle that cannot be the one that flies."""

from dataclasses import replace

import numpy as np
import pytest
from made_flights import Pass, made_flight
from resting_signals import level_command

from q2q_model.flights.flight import Flight
from q2q_model.identification.carried_weight import CarriedWeight
from q2q_model.identification.push.recorded_push import check_weight
from q2q_model.signals.values import SwarmState
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, TEXTBOOK_065, Vehicle

FLOWN = made_flight(Pass())


def carried(flight: Flight, vehicle: Vehicle) -> CarriedWeight:
    """Return the counts of a flight, whose commands name the vehicles the other way around."""
    found, zeros, status = CarriedWeight(vehicle), np.zeros(2), np.zeros(2, dtype=np.uint8)
    for k, t in enumerate(flight.t):
        unknown = np.zeros((2, 3))
        pose = flight.pos[k], unknown, flight.quat[k], unknown
        found.update(
            SwarmState(float(t), flight.names, *pose, zeros, status),
            level_command(float(t), flight.names[::-1], flight.thrust[k][::-1]),
        )
    return found


@pytest.mark.parametrize("factor", [0.3, 0.45, 0.55, 1.0, 1.9, 2.1, 20.0])
def test_the_judgement_of_each_vehicle_is_that_of_a_recorded_flight(factor: float) -> None:
    flight = replace(FLOWN, thrust=FLOWN.thrust * np.array([1.0, factor]))
    doubt = carried(flight, CRAZYFLIE_2_0).doubt()
    if doubt:
        side = "below 0.5" if factor < 1.0 else "above 2"
        assert doubt.startswith(f"the median thrust of cf2 in the air is {side} times")
        with pytest.raises(ValueError, match="the median thrust of cf2 in the air"):
            check_weight(flight, CRAZYFLIE_2_0)
    else:
        check_weight(flight, CRAZYFLIE_2_0)
    assert bool(doubt) == (not 0.5 < factor < 2.0)


def test_another_vehicle_is_reported_after_two_seconds_in_the_air() -> None:
    for ticks, known in ((199, False), (200, True)):
        found = carried(replace(FLOWN, t=FLOWN.t[:ticks]), TEXTBOOK_065)
        assert found.judged() == known
        assert ("weight of textbook_065: name the vehicle with --vehicle" in found.doubt()) == known


def test_on_the_ground_nothing_is_judged() -> None:
    low = replace(FLOWN, pos=FLOWN.pos * 0.1)
    assert not carried(low, TEXTBOOK_065).judged()
    assert not carried(low, TEXTBOOK_065).doubt()
