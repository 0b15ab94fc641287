"""In closed loop, predictions corrected by accelerometers make up for a wrong model."""

from dataclasses import replace

import numpy as np

from q2q_model.downwash.jet import Jet
from q2q_model.downwash.residual_process import REAL_FLIGHTS, ResidualProcess
from q2q_model.files.find_model import find_model
from q2q_sim.loop.closed_loop import FlightOptions, fly
from q2q_sim.scenarios import library


def errors(correct: ResidualProcess | None) -> tuple[float, float]:
    """Return the rms errors of eta under a wake [m/s^2] and of altitude [m], with a weak model."""
    scenario = replace(library.load("table6_room"), duration=24.0)
    model = find_model(scenario.model).interaction
    assert isinstance(model, Jet)
    flight = fly(
        scenario, FlightOptions(model=replace(model, strength=0.7 * model.strength), correct=correct)
    )
    true = flight.true_eta[..., 2]
    missed, high = flight.eta[..., 2] - true, (flight.true_pos - flight.ref_pos)[200:, :, 2]
    return float(np.sqrt(np.mean(missed[np.abs(true) > 0.2] ** 2))), float(np.sqrt(np.nanmean(high**2)))


def test_a_weak_model_flies_better_when_it_is_corrected() -> None:
    eta, altitude = errors(None)
    corrected_eta, corrected_altitude = errors(REAL_FLIGHTS)
    assert corrected_eta < 0.5 * eta  # 0.3 found
    assert corrected_altitude < 0.6 * altitude  # 0.4 found
