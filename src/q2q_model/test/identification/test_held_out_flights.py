"""Every flight is predicted by a jet that was not fitted to it."""

from dataclasses import replace

import numpy as np
import pytest

from q2q_model.downwash.jet import MEASURED_LAW, Jet
from q2q_model.identification.jet.held_out_flights import held_out_scores
from q2q_model.identification.jet.jet_fit import fit_to_pushes
from q2q_model.identification.jet.jet_form import JetForm
from q2q_model.identification.push.along_flight import Motion, eta_along, eta_on_vehicle
from q2q_model.identification.push.push_samples import PushRecord, PushSamples, push_samples

STRONG = replace(MEASURED_LAW, strength=1.5 * MEASURED_LAW.strength)


def flown(name: str, height: float, law: Jet = MEASURED_LAW) -> list[PushSamples]:
    """Return a flight in which vehicle 1 passes `height` above vehicle 0, in the air of a law."""
    ticks = 900
    pos = np.zeros((ticks, 2, 3))
    pos[..., 2] = 1.0
    pos[:, 1] += np.stack([np.zeros(ticks), np.linspace(-1.0, 1.0, ticks), np.full(ticks, height)], axis=1)
    up = np.tile([0.0, 0.0, 1.0], (ticks, 2, 1))
    motion = Motion(0.01 * np.arange(ticks), pos, np.gradient(pos, 0.01, axis=0), up)
    good = np.ones((ticks, 2), dtype=bool)
    push = eta_along(law, motion)[..., 2]
    return push_samples(PushRecord(name, ("a", "b"), motion, push, good, ~good))


def test_a_flight_in_other_air_is_scored_by_the_jet_of_the_others() -> None:
    training = {"one": flown("one", 0.4), "two": flown("two", 0.6), "odd": flown("odd", 0.5, STRONG)}
    found = {one.name: one for one in held_out_scores(training, {}).flights}
    assert found["odd"].fitted_to == ("one", "two")
    own, lower = found["odd"], found["odd"].samples[0]
    jet = fit_to_pushes([*training["one"], *training["two"]], JetForm()).jet
    rows = np.nonzero(lower.exposed)[0]
    eta = eta_on_vehicle(jet, lower.motion, lower.vehicle, rows)[:, 2]
    assert own.predicted[0][rows] == pytest.approx(eta)
    gain = (eta @ lower.y[rows]) / (lower.y[rows] @ lower.y[rows])
    assert gain == pytest.approx(1.0 / 1.5, rel=0.1)  # a jet fitted at 0.4 and 0.6 m interpolates
    assert found["one"].fitted_to == ("two", "odd")


def test_flights_of_one_law_are_predicted_and_further_ones_by_the_jet_of_all_training_flights() -> None:
    training = {"one": flown("one", 0.4), "two": flown("two", 0.6)}
    scores = held_out_scores(training, {"new": flown("new", 0.5), "far": flown("far", 3.0)})
    assert [one.name for one in scores.flights] == ["one", "two", "new"]
    assert scores.flights[2].fitted_to == ("one", "two")
    assert (
        scores.flights[2].score.r2_exposed or 0.0
    ) > 0.95  # at a height between those of the training ones


def test_the_pooled_score_weighs_every_sample_alike() -> None:
    training = {"one": flown("one", 0.4), "two": flown("two", 0.6), "odd": flown("odd", 0.5, STRONG)}
    scores = held_out_scores(training, {})
    y, missed = [], []
    for one in scores.flights:
        for sample, eta in zip(one.samples, one.predicted, strict=True):
            y.append(sample.y[sample.exposed])
            missed.append((sample.y - eta)[sample.exposed])
    y_all, missed_all = np.concatenate(y), np.concatenate(missed)
    assert scores.together.r2_exposed == pytest.approx(1.0 - np.sum(missed_all**2) / np.sum(y_all**2))
    assert scores.together.n == len(y_all)


def test_one_flight_under_another_cannot_be_left_out() -> None:
    with pytest.raises(ValueError, match="1 of 2 flights have a vehicle"):
        held_out_scores({"one": flown("one", 0.4), "far": flown("far", 3.0)}, {})
