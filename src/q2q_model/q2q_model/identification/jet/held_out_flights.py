"""Jets fitted to measured downwash and scored on flights that they were not fitted to.

Each training flight is predicted by the jet of the other training flights (leave one out), and each further
flight by the jet of all training flights.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from q2q_model.downwash.jet import Jet
from q2q_model.identification.jet.held_out_deviation import with_held_out_deviation
from q2q_model.identification.jet.jet_fit import fit_to_pushes
from q2q_model.identification.jet.jet_form import JetForm
from q2q_model.identification.push.push_samples import (
    GAPS,
    PushSamples,
    PushScore,
    pooled_score,
    residual_of,
    score,
)
from q2q_model.signals.values import Array

FEWEST_FLIGHTS = 2
"""Flights with a vehicle under another that leaving one out needs."""

FlightSamples = Mapping[str, Sequence[PushSamples]]
"""Samples of each vehicle of a flight, by the flight's name."""


@dataclass(frozen=True, slots=True)
class HeldOutFlight:
    """Flight with the prediction of a jet that was not fitted to it."""

    name: str
    samples: tuple[PushSamples, ...]
    predicted: tuple[Array, ...]
    """eta [m/s^2], (T,), for each of `samples`; NaN in rows that are not usable."""
    score: PushScore
    fitted_to: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class HeldOutScores:
    """Jet of all training flights, and every flight predicted without itself."""

    jet: Jet
    flights: tuple[HeldOutFlight, ...]

    @property
    def together(self) -> PushScore:
        """Return the score pooled over all flights."""
        samples = [sample for one in self.flights for sample in one.samples]
        y = [sample.y[sample.exposed] for sample in samples]
        predicted = [eta for one in self.flights for eta in one.predicted]
        misses = [(sample.y - eta)[sample.exposed] for sample, eta in zip(samples, predicted, strict=True)]
        return pooled_score(y, misses, samples)


def held_out_scores(training: FlightSamples, further: FlightSamples) -> HeldOutScores:
    """Return the jet of the training flights and the scores of every flight with exposed rows.

    Raises:
        ValueError: fewer than two training flights have a vehicle under another.
    """
    known, form = _with_wake(training), JetForm()
    if len(known) < FEWEST_FLIGHTS:
        raise ValueError(
            f"{len(known)} of {len(training)} flights have a vehicle {GAPS[0]} to {GAPS[1]} m under another "
            f"with a measured push; leaving one out needs at least {FEWEST_FLIGHTS}"
        )
    found = []
    for name, samples in known.items():
        others = {other: some for other, some in known.items() if other != name}
        found.append(_held_out(name, samples, fit_to_pushes(_all(others), form).jet, others))
    jet = with_held_out_deviation(fit_to_pushes(_all(known), form).jet, _all(known), form)
    found += [_held_out(name, samples, jet, known) for name, samples in _with_wake(further).items()]
    return HeldOutScores(jet, tuple(found))


def _held_out(name: str, samples: Sequence[PushSamples], jet: Jet, fitted: FlightSamples) -> HeldOutFlight:
    predicted = tuple(np.where(one.usable, one.y - residual_of(jet, one), np.nan) for one in samples)
    return HeldOutFlight(name, tuple(samples), predicted, score(jet, samples), tuple(fitted))


def _with_wake(flights: FlightSamples) -> dict[str, Sequence[PushSamples]]:
    return {name: some for name, some in flights.items() if any(one.exposed.any() for one in some)}


def _all(flights: FlightSamples) -> list[PushSamples]:
    return [sample for some in flights.values() for sample in some]
