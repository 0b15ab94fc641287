"""Models of the ablation, learned from recorded flights of one family, and its air.

Each model is a jet of the simplest moving form, fitted to the measured pushes of one flight or of one part of
it (q2q_model.identification.force.jet_fit): a flight is cut into as many parts of equal numbers of samples as
have LEAST samples under another vehicle. No two models share a sample, so that the spread between them is
that of models learned from different flights. They do not know what part of a jet a vehicle in it absorbs.
"""

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from q2q_model.downwash.jet import Jet
from q2q_model.identification.force.downwash_force import ForceSamples, force_samples
from q2q_model.identification.force.jet_fit import JetForm, fit_to_pushes
from q2q_model.identification.identification import force_record
from q2q_model.identification.recording_files import recording_of_table
from q2q_model.vehicle.constants import CRAZYFLIE_2_1
from q2q_sim.air.air_names import FLIGHTS
from q2q_sim.air.find_air import find_air
from q2q_sim.air.room_air import RoomAir
from q2q_sim.experiments.ablation.ablation_cases import Plant

LEAST = 600
"""Fewest samples under another vehicle behind a model: 6 s."""
FORM = JetForm()


@dataclass(frozen=True, slots=True)
class LearnedModel:
    """Model with the recording that it was learned from."""

    name: str
    """Flight, and which part of it: "dc19_randomwalk_ss_04, part 2 of 4"."""
    jet: Jet


def models_of(family: str) -> list[LearnedModel]:
    """Return the models learned from a family's flights.

    Raises:
        ValueError: the flights are not there.
    """
    with threadpool_limits(1, user_api="blas"):  # more threads are slower on small matrices
        return [model for path in _tables(family) for model in _models(path)]


def air_of(plant: Plant) -> RoomAir:
    """Return the air of a plant.

    Raises:
        ValueError: it was not learned from flights.
    """
    found = find_air(plant.air)
    if isinstance(found, RoomAir):
        return found
    raise ValueError(f"air {plant.air} is not learned from flights")


def parts_of(samples: Sequence[ForceSamples]) -> list[list[ForceSamples]]:
    """Return a flight's samples in parts of equal numbers under another vehicle, LEAST or more in each."""
    times = np.sort(np.concatenate([np.empty(0), *(one.motion.t[one.exposed] for one in samples)]))
    count = times.size // LEAST
    inner = [float(times[times.size * k // count]) for k in range(1, count)]
    ends = [-np.inf, *inner, np.inf] if count else []
    return [[_between(one, *span) for one in samples] for span in pairwise(ends)]


def _models(path: Path) -> list[LearnedModel]:
    record = force_record(recording_of_table(path), CRAZYFLIE_2_1, CRAZYFLIE_2_1.thrust_lag)
    parts = [] if record is None else parts_of(force_samples(record))
    ways = [f", part {k} of {len(parts)}" for k in range(1, len(parts) + 1)] if len(parts) > 1 else [""]
    return [
        LearnedModel(f"{path.stem}{way}", fit_to_pushes(part, FORM).jet)
        for way, part in zip(ways, parts, strict=False)
    ]


def _between(one: ForceSamples, start: float, end: float) -> ForceSamples:
    inside = (one.motion.t >= start) & (one.motion.t < end)
    return replace(one, exposed=one.exposed & inside, upper=one.upper & inside)


def _tables(family: str) -> list[Path]:
    """Return the tables of a family's flights of two and three vehicles."""
    folder = Path(os.environ.get("Q2Q_DATA", "../shared/data")) / FLIGHTS
    found = sorted(folder.glob(f"{family}_*_ss*.parquet"))
    if not found:
        raise ValueError(
            f"no recorded flights {family} in {folder}: get those of docs/real_flights.md and set Q2Q_DATA "
            f"to the folder of {FLIGHTS}/, or begin from the numbers of docs/ablation.json"
        )
    return found
