"""Models of the ablation, learned from recorded flights of one family.

Each model is a jet of the simplest moving form, fitted to the measured pushes of one flight or of one part of
it (q2q_model.identification.jet.jet_fit), with LEAST samples or more under another vehicle. Of a family,
MOST models are learned, each from a flight; a family with fewer flights is cut into parts of equal numbers of
samples, of which the second of a flight comes after the first of all others. No two share a sample, so that
the spread between them is that of models learned from different flights. One more model is learned from all
flights of the family. The residual of a model is that on all of them. Models do not know what part of a jet a
vehicle in it absorbs.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise, zip_longest
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from q2q_model.downwash.correction.residual_process import REAL_FLIGHTS, ResidualProcess
from q2q_model.downwash.jet import PAPER_LAW, Jet
from q2q_model.identification.jet.jet_fit import fit_to_pushes
from q2q_model.identification.jet.jet_form import JetForm
from q2q_model.identification.jet.residual_fit import fit_residual
from q2q_model.identification.push.push_samples import PushSamples, push_samples
from q2q_model.identification.push.recorded_push import push_record
from q2q_model.recordings.recording_reader import recording_of_table
from q2q_model.vehicle.constants import CRAZYFLIE_2_1
from q2q_sim.air.air_names import FLIGHTS, flights_folder
from q2q_sim.experiments.ablation.ablation_cases import LAW

LEAST = 600
"""Fewest samples under another vehicle behind a model: 6 s."""
MOST = 5
"""Models of a family."""
FORM = JetForm()


@dataclass(frozen=True, slots=True)
class LearnedModel:
    """Model with the recording that it was learned from."""

    name: str
    """Flight, and which part of it: "dc19_randomwalk_ss_04, part 2 of 4"."""
    jet: Jet
    residual: ResidualProcess | None = None

    @property
    def process(self) -> ResidualProcess:
        """Return the residual, that of real flights where there is none."""
        return self.residual or REAL_FLIGHTS


def models_of(family: str) -> list[LearnedModel]:
    """Return the models learned from parts of a family's flights, then that of all; of LAW, the law.

    Raises:
        ValueError: the flights are not there.
    """
    if family == LAW:
        return [LearnedModel("paper_law", PAPER_LAW)] * 2
    with threadpool_limits(1, user_api="blas"):  # more threads are slower on small matrices
        flights = {path.stem: _samples(path) for path in _tables(family)}
        every = [one for samples in flights.values() for one in samples]
        chosen = [*_chosen(flights), (f"{family}, all flights", every)]
        return [_learned(name, samples, every) for name, samples in chosen]


def parts_of(samples: Sequence[PushSamples]) -> list[list[PushSamples]]:
    """Return a flight's samples in parts of equal numbers under another vehicle, LEAST or more in each."""
    times = np.sort(np.concatenate([np.empty(0), *(one.motion.t[one.exposed] for one in samples)]))
    count = times.size // LEAST
    inner = [float(times[times.size * k // count]) for k in range(1, count)]
    ends = [-np.inf, *inner, np.inf] if count else []
    return [[_between(one, *span) for one in samples] for span in pairwise(ends)]


def _chosen(flights: Mapping[str, Sequence[PushSamples]]) -> list[tuple[str, list[PushSamples]]]:
    """Return names and samples of MOST flights, or parts of them."""
    parts = {name: found for name, samples in flights.items() if (found := parts_of(samples))}
    if len(parts) >= MOST:
        return [(name, list(flights[name])) for name in list(parts)[:MOST]]
    named = [
        [
            (f"{name}, part {k} of {len(found)}" if len(found) > 1 else name, part)
            for k, part in enumerate(found, 1)
        ]
        for name, found in parts.items()
    ]
    rounds = [part for same in zip_longest(*named) for part in same if part is not None]
    return sorted(rounds[:MOST], key=lambda part: part[0])


def _learned(name: str, samples: Sequence[PushSamples], family: Sequence[PushSamples]) -> LearnedModel:
    """Return the model of some samples, with its residual on all of the family."""
    jet = fit_to_pushes(samples, FORM).jet
    residual = fit_residual(jet, family)
    return LearnedModel(name, jet, None if residual is None else residual.process)


def _samples(path: Path) -> list[PushSamples]:
    record = push_record(recording_of_table(path), CRAZYFLIE_2_1, CRAZYFLIE_2_1.thrust_lag)
    return [] if record is None else push_samples(record)


def _between(one: PushSamples, start: float, end: float) -> PushSamples:
    inside = (one.motion.t >= start) & (one.motion.t < end)
    return replace(one, exposed=one.exposed & inside, upper=one.upper & inside)


def _tables(family: str) -> list[Path]:
    """Return the tables of a family's flights of two and three vehicles."""
    folder = flights_folder()
    found = sorted(folder.glob(f"{family}_*_ss*.parquet"))
    if not found:
        raise ValueError(
            f"no recorded flights {family} in {folder}: get those of docs/real_flights.md and set Q2Q_DATA "
            f"to the folder of {FLIGHTS}/, or start from the numbers of docs/ablation.json"
        )
    return found
