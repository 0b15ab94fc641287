"""Vertical push of real flights, each predicted by jets fitted to other flights.

One jet is fitted to other flights of the same family; its form is chosen by cross-validation among those
flights, so that no flight is scored by a model that it helped to fit or to choose. The other jet is fitted to
the other family alone. The reference is what the vehicles' own network said in flight (`fa_ff`: Shi et al.,
Neural-Swarm2, T-RO 2021), on the same rows and by the same rule
(q2q_model.identification.push.push_samples), its force divided by the mass by which the measured one is. That
network was trained on flights of this source; in the family dc19 it was off. Vehicles with too little clear
air to be scored are named. Needs the flights of Q2Q_DATA.
"""

import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from q2q_model.downwash.jet import Jet
from q2q_model.identification.jet.held_out_deviation import with_held_out_deviation
from q2q_model.identification.jet.jet_deviation import Z95
from q2q_model.identification.jet.jet_fit import fit_to_pushes
from q2q_model.identification.jet.jet_form import JetForm
from q2q_model.identification.push.log_mass import log_masses
from q2q_model.identification.push.push_samples import (
    FEWEST_FREE,
    PushRecord,
    PushSamples,
    push_samples,
    residual_of,
    scored_rows,
)
from q2q_model.identification.push.recorded_push import push_record
from q2q_model.identification.push.residual import predicted_residual
from q2q_model.identification.selection.model_choice import MARGIN
from q2q_model.recordings.flight_recording import Recording
from q2q_model.recordings.recordings_of_bags import recordings_of_bags
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import CRAZYFLIE_2_1
from q2q_sim.tools.import_table import flight_table, read_columns, write_bag
from row import Row

FLIGHTS = Path(os.environ.get("Q2Q_DATA", "../shared/data")) / "neural_swarm"
FAMILIES = ("dc19", "dc21")
"""Feed-forward off, on."""
PAIRS, TRIPLES = "_ss_", "_sss_"
REFERENCE = "the vehicles' network"
FORMS = (JetForm(), JetForm(loaded=True))
"""Candidate forms, the simpler first."""
OUTER_FOLDS, INNER_FOLDS = 4, 2
"""Folds of flights that score, and that choose the form."""


@dataclass(frozen=True, slots=True)
class _Flight:
    name: str
    samples: list[PushSamples]
    network: list[Array]
    """Acceleration predicted in flight [m/s^2], (T,), for each of `samples`."""


@dataclass(frozen=True, slots=True)
class _Residuals:
    """What predictions leave of y over the exposed rows of one vehicle [m/s^2], (k,) each."""

    flight: str
    y: Array
    jet: Array
    ahead: Array
    """Of the jet 20 ms ahead."""
    stranger: Array
    """Of the jet of the other family."""
    network: Array
    within: Array
    """Whether the jet's residual lies within 1.96 of its deviations."""


def run() -> list[Row]:
    """Return R2 of each flight, of all pairs and of all triples, now and 20 ms ahead."""
    if not FLIGHTS.is_dir():
        print(f"bench: real: no flights in {FLIGHTS}: set Q2Q_DATA", file=sys.stderr)
        return []
    flown = {family: _flights(sorted(FLIGHTS.glob(f"{family}_*_ss*.parquet"))) for family in FAMILIES}
    jets = {family: fit_to_pushes(_samples(flights), FORMS[-1]).jet for family, flights in flown.items()}
    rows = []
    for family, flights in flown.items():
        stranger = next(jet for other, jet in jets.items() if other != family)
        residuals = [part for k in range(OUTER_FOLDS) for part in _fold(flights, k, stranger)]
        for one in flights:
            rows += _rows(one.name, [part for part in residuals if part.flight == one.name])
        for kind, mark in (("pairs", PAIRS), ("triples", TRIPLES)):
            rows += _rows(f"{family}, all {kind}", [part for part in residuals if mark in part.flight])
    return rows


def _flights(tables: Sequence[Path]) -> list[_Flight]:
    with TemporaryDirectory() as scratch:
        bags = [Path(scratch) / table.stem for table in tables]
        for table, bag in zip(tables, bags, strict=True):
            write_bag(flight_table(read_columns(table)), bag)
        recordings, _ = recordings_of_bags(bags)
    return [_flight(one) for one in recordings]


def _flight(recording: Recording) -> _Flight:
    record = push_record(recording, CRAZYFLIE_2_1, CRAZYFLIE_2_1.thrust_lag)
    if record is None or recording.log is None:
        raise ValueError(f"{recording.flight.name} has no measured push")
    _name_unscored(record)
    masses = log_masses(recording.log, recording.flight, CRAZYFLIE_2_1)
    samples, lines = push_samples(record), recording.log.column("fa_ff") / masses
    return _Flight(recording.flight.name, samples, [lines[:, one.vehicle] for one in samples])


def _name_unscored(record: PushRecord) -> None:
    """Print the vehicles under another that are not scored, with their rows there."""
    for name, rows in zip(record.names, scored_rows(record), strict=True):
        free, exposed = int(rows.free.sum()), int(rows.exposed.sum())
        if exposed and free < FEWEST_FREE:
            print(
                f"bench: real: {record.name}: {name} is not scored: {exposed} of its samples are under "
                f"another vehicle, but {free} in clear air, and {FEWEST_FREE} are needed",
                file=sys.stderr,
            )


def _samples(flights: Sequence[_Flight]) -> list[PushSamples]:
    return [sample for one in flights for sample in one.samples]


def _fold(flights: Sequence[_Flight], fold: int, stranger: Jet) -> list[_Residuals]:
    """Return the residuals on every OUTER_FOLDS-th flight with exposed rows of a jet fitted to the others."""
    under = [one for one in flights if any(sample.exposed.any() for sample in one.samples)]
    left_out = under[fold::OUTER_FOLDS]
    if not left_out:
        return []
    training = [one for one in flights if one not in left_out]
    form = _chosen(training)
    jet = with_held_out_deviation(fit_to_pushes(_samples(training), form).jet, _samples(training), form)
    return [part for one in left_out for part in _residuals(one, jet, stranger)]


def _chosen(training: Sequence[_Flight]) -> JetForm:
    """Return the form with the least error on held-out flights of `training`; of one, the simplest."""
    under = [one for one in training if any(sample.exposed.any() for sample in one.samples)]
    if len(under) < INNER_FOLDS:
        return FORMS[0]
    left = []
    for form in FORMS:
        squared_residuals = 0.0
        for k in range(INNER_FOLDS):
            rest = [one for index, one in enumerate(under) if index % INNER_FOLDS != k]
            jet = fit_to_pushes(_samples(rest), form).jet
            for sample in _samples(under[k::INNER_FOLDS]):
                squared_residuals += float(np.sum(residual_of(jet, sample)[sample.exposed] ** 2))
        left.append(squared_residuals)
    return FORMS[1] if left[1] < (1.0 - MARGIN) * left[0] else FORMS[0]


def _residuals(flight: _Flight, jet: Jet, stranger: Jet) -> list[_Residuals]:
    """Return the residuals of jets on each vehicle under another."""
    found = []
    for sample, network in zip(flight.samples, flight.network, strict=True):
        rows, residual = sample.exposed, residual_of(jet, sample)
        ahead = residual - predicted_residual(sample.motion.t, residual, sample.usable)
        y, strange = sample.y[rows], residual_of(stranger, sample)[rows]
        jet_residual = residual[rows]
        std = jet.std_floor + jet.relative_std * np.abs(y - jet_residual)
        within = (np.abs(jet_residual) <= Z95 * std).astype(np.float64)
        found.append(
            _Residuals(flight.name, y, jet_residual, ahead[rows], strange, y - network[rows], within)
        )
    return found


def _rows(name: str, residuals: Sequence[_Residuals]) -> list[Row]:
    """Return R2 now, with the network's where it was on, and ahead; none without exposed rows."""
    y = np.concatenate([np.empty(0), *(one.y for one in residuals)])
    if not y.size:
        return []
    kinds = ("jet", "ahead", "stranger", "network")
    left = {kind: np.concatenate([getattr(one, kind) for one in residuals]) for kind in kinds}
    r2 = {kind: 1.0 - float(values @ values) / float(y @ y) for kind, values in left.items()}
    on = bool((left["network"] != y).any())
    beside = f"{REFERENCE}: {r2['network']:.3f}" if on else None
    ratio = (1.0 - r2["network"]) / (1.0 - r2["jet"]) if on else None
    label, within = f"{name}, {y.size} samples", np.concatenate([one.within for one in residuals])
    return [
        Row(label, r2["jet"], "R2", beside, ratio),
        Row(f"{label}, 20 ms ahead", r2["ahead"], "R2"),
        Row(f"{label}, by the other family", r2["stranger"], "R2"),
        Row(f"{label}, within the 95 % band", float(np.mean(within)), "of 1"),
    ]
