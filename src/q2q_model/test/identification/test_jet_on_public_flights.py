"""A jet predicts public flights that it has not seen, as well as it claims."""

from functools import cache

import numpy as np
from public_flights import OFF, ON, needs_flights, real_samples

from q2q_model.downwash.jet import Jet
from q2q_model.identification.jet.held_out_deviation import with_held_out_deviation
from q2q_model.identification.jet.jet_fit import fit_to_pushes
from q2q_model.identification.jet.jet_form import JetForm
from q2q_model.identification.push.along_flight import eta_along, eta_on_vehicle
from q2q_model.identification.push.log_mass import LOG_MASS
from q2q_model.identification.push.push_samples import (
    PushSamples,
    pooled_score,
    score,
)
from q2q_model.signals.values import Mask


@cache
def held_out(family: str, form: JetForm) -> tuple[float, float]:
    """Return R2 on flights left out of the fit one after the other, and the mean push on upper vehicles."""
    flights = real_samples(family)
    y, misses = [], []
    for name, samples in flights.items():
        others = [one for other, found in flights.items() if other != name for one in found]
        jet = fit_to_pushes(others, form).jet
        for one in samples:
            if one.exposed.any():
                eta = eta_along(jet, one.motion)[one.exposed, one.vehicle, 2]
                y.append(one.y[one.exposed])
                misses.append(y[-1] - eta)
    found = pooled_score(y, misses, [one for samples in flights.values() for one in samples])
    assert found.r2_exposed is not None
    assert found.mean_upper_mps2 is not None
    return found.r2_exposed, found.mean_upper_mps2


@needs_flights
def test_a_jet_predicts_real_flights_it_has_not_seen_feed_forward_off() -> None:
    r2, upper = held_out(OFF, JetForm())
    assert r2 >= 0.86  # issue 3 asks for 0.84; 0.865 found
    assert abs(upper) < 0.1  # no effect on the upper vehicle


@needs_flights
def test_what_moves_matters_on_real_flights() -> None:
    """The same jet that falls straight down explains less: the source's slope and speed are no ornament."""
    moving, straight = (held_out(OFF, JetForm(carried=carried))[0] for carried in (1.0, 0.0))
    assert 1.0 - moving < 0.8 * (1.0 - straight)


@needs_flights
def test_feed_forward_on_is_predicted_too() -> None:
    """Four flights of the family, two and three vehicles; the whole family takes minutes and gives 0.863."""
    flights = {name: found for name, found in real_samples(ON).items() if name.startswith("dc21_swap_s")}
    names = list(flights)
    chosen = names[::2]
    training = [one for name in names if name not in chosen for one in flights[name]]
    jet = with_held_out_deviation(fit_to_pushes(training, JetForm()).jet, training, JetForm())
    found = score(jet, [one for name in chosen for one in flights[name]])
    assert found.r2_exposed is not None
    assert found.r2_exposed >= 0.80
    assert found.r2_ahead_20ms is not None
    assert found.r2_ahead_20ms >= 0.93
    assert LOG_MASS == 0.032
    within = [_within_band(jet, one) for name in chosen for one in flights[name] if one.exposed.any()]
    assert 0.93 <= np.concatenate(within).mean() <= 0.97  # of 95 %: 0.944 over the whole family


@needs_flights
def test_the_deviation_that_one_flight_teaches_holds_on_the_other_flight_feed_forward_off() -> None:
    """One flight cannot show how flights differ; its halves show the doubt of a fit to half as much."""
    flights = list(real_samples(OFF).values())
    within = []
    for training, other in zip(flights, reversed(flights), strict=True):
        jet = with_held_out_deviation(fit_to_pushes(training, JetForm()).jet, training, JetForm())
        within += [_within_band(jet, one) for one in other if one.exposed.any()]
    assert len(flights) == 2
    assert 0.93 <= np.concatenate(within).mean() <= 0.97  # of 95 %: 0.931; by its own misses 0.909


def _within_band(jet: Jet, one: PushSamples) -> Mask:
    """Return which exposed rows lie within 1.96 of the deviations that the model claims."""
    rows = np.nonzero(one.exposed)[0]
    eta = eta_on_vehicle(jet, one.motion, one.vehicle, rows)[:, 2]
    return np.abs(one.y[rows] - eta) <= 1.96 * (jet.std_floor + jet.relative_std * np.abs(eta))
