"""In closed loop, controllers corrected by accelerometers make up for a wrong model."""

from dataclasses import replace
from functools import cache

import numpy as np

from q2q_model.downwash.correction.residual_process import REAL_FLIGHTS
from q2q_model.downwash.jet import Jet
from q2q_model.flights.flight import Flight
from q2q_model.model_files.find_model import find_model
from q2q_model.vehicle.constants import GRAVITY
from q2q_sim.loop.closed_loop import FlightOptions, fly
from q2q_sim.monitors.metrics.flight_metrics import measure
from q2q_sim.scenarios import library
from q2q_sim.scenarios.scenario_variants import with_air

ROOM = replace(library.load("table6_measured"), duration=27.0)


@cache
def flown(controller: str, air: str, *, corrects: bool, strength: float = 1.0) -> Flight:
    """Return a passage in an air, with a model of another strength, corrected or not."""
    model = find_model(ROOM.model).interaction
    assert isinstance(model, Jet)
    known = replace(model, strength=strength * model.strength)
    residual_process = REAL_FLIGHTS if corrects else None
    options = FlightOptions(controller=controller, model=known, residual_process=residual_process)
    return fly(with_air(ROOM, air, ()) if air else ROOM, options)


def under(flight: Flight) -> float:
    """Return the height error of the lower vehicle under the other one [m]."""
    return measure(flight, ROOM.vehicle).vehicles["cf1"].under_rms_m


def test_a_weak_model_flies_better_when_it_is_corrected() -> None:
    plain, better = (under(flown("pid", "", corrects=one, strength=0.7)) for one in (False, True))
    assert better < 0.5 * plain  # 0.3 found


def test_air_of_another_family_is_held_better_with_correction() -> None:
    plain, better = (under(flown("mpc", "room", corrects=one)) for one in (False, True))
    assert better < 0.5 * plain  # 0.3 found


def test_noise_and_gusts_move_the_thrust_by_few_hundredths_of_weight() -> None:
    flight = flown("mpc", "room", corrects=True)
    clear = flight.thrust[400:1400, 0] / ROOM.vehicle.mass
    assert np.std(clear) < 0.06 * GRAVITY  # 0.04 found; gusts alone are 0.02
