"""A flight of q2q validates in its own air, whether its controllers compensated downwash or ignored it."""

from dataclasses import replace

import numpy as np
import pytest

from q2q_model.model_files.find_model import find_model
from q2q_model.recordings.flight_recording import Recording
from q2q_sim.air.lookup.find_air import find_air
from q2q_sim.experiments.validation.drawn_air import draws_in
from q2q_sim.experiments.validation.recorded.tracked_flight import TrackedFlight, tracked_flight
from q2q_sim.experiments.validation.validate_flights import _flight_notes
from q2q_sim.experiments.validation.validated_flight import (
    RMS_RATIO,
    ValidatedFlight,
    as_json,
    pooled_comparison,
    validate_flight,
)
from q2q_sim.loop.closed_loop import FlightOptions, fly
from q2q_sim.loop.flight_blocks import Mode
from q2q_sim.plant.room_vehicle import vehicle_of_room
from q2q_sim.scenarios import library
from q2q_sim.scenarios.scenario_variants import with_air

SCENARIO = with_air(library.load("table6_room"), "room", ())
DRAWS = 6


def flown(mode: Mode) -> Recording:
    """Return a flight in the room, with its model as a bag's metadata name it."""
    options = FlightOptions(mode=mode, model=find_model(SCENARIO.model).interaction)
    return Recording(fly(SCENARIO, options), model=SCENARIO.model)


def flown_again(flight: TrackedFlight) -> ValidatedFlight:
    """Return a flight of the room validated in it."""
    air = find_air("room")
    vehicle = vehicle_of_room(air, SCENARIO.vehicle)
    return validate_flight(flight, vehicle, draws_in(air, flight, SCENARIO.vehicle), range(DRAWS))


def rms_ratio(one: ValidatedFlight) -> float:
    """Return the simulated over the recorded height error under a wake."""
    found = pooled_comparison([one])
    assert found.n > 500
    assert found.z_rms_ratio is not None
    return found.z_rms_ratio


@pytest.fixture(scope="module")
def compensated() -> Recording:
    """Return a flight whose controllers compensate."""
    return flown("aware")


def test_the_compensation_of_a_flight_follows_the_simulated_vehicles(compensated: Recording) -> None:
    flight = tracked_flight(compensated, SCENARIO.vehicle)
    assert flight.model is not None
    one = flown_again(flight)
    assert one.law.compensates
    assert RMS_RATIO[0] < rms_ratio(one) < RMS_RATIO[1]
    replayed = flown_again(replace(flight, model=None))
    assert rms_ratio(replayed) > 1.5  # it comes where the recorded vehicle was
    assert _flight_notes(one) == []
    assert ["is repeated as recorded" in note for note in _flight_notes(replayed)] == [True]


def test_a_prediction_that_the_controllers_ignored_is_not_compensated() -> None:
    flight = tracked_flight(flown("ignoring"), SCENARIO.vehicle)
    assert np.abs(flight.compensated).max() > 1.0
    one = flown_again(flight)
    assert not one.law.compensates
    assert not one.flight.compensated.any()
    assert RMS_RATIO[0] < rms_ratio(one) < RMS_RATIO[1]
    pid = SCENARIO.overrides["pid"]
    found = as_json([one])["flights"][one.flight.name]["loop"]
    assert found["k_p"] == pytest.approx([pid["k_p_xy"], pid["k_p_xy"], pid["k_p_z"]], rel=0.03)
    assert found["k_d"] == pytest.approx([pid["k_d_xy"], pid["k_d_xy"], pid["k_d_z"]], rel=0.03)


@pytest.mark.parametrize("model", ["", "paper_law", "gone.q2q"])
def test_a_model_that_does_not_give_the_recorded_prediction_is_not_used(
    compensated: Recording, model: str
) -> None:
    assert tracked_flight(replace(compensated, model=model), SCENARIO.vehicle).model is None
