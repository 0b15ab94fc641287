"""Demonstration on recorded flights: fit a model, score it on flights left out, fly it, and write one page.

The model is fitted to one family of flights (the start of their names), and the air that it is flown in was
learned from another: they share no flight.
"""

import sys
from argparse import Namespace
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from threadpoolctl import threadpool_limits

from q2q_model.documents.json_file import write_json
from q2q_model.flights.duplicates.same_flight import flight_digest
from q2q_model.identification.jet.held_out_flights import HeldOutScores, held_out_scores
from q2q_model.identification.push.push_samples import FEWEST_FREE, PushSamples, push_samples
from q2q_model.identification.push.recorded_push import push_record
from q2q_model.model_files.model_file import Fit, ModelFile, save
from q2q_model.recordings.recordings_of_paths import recordings_of_paths
from q2q_model.recordings.vehicle_of_flights import vehicle_of_flights
from q2q_model.vehicle.constants import Vehicle
from q2q_sim.air.air_file import load
from q2q_sim.air.air_names import ROOM, air_path, flights_folder
from q2q_sim.node_flights.flight_request import FlightRequest
from q2q_sim.node_flights.flight_run import FlightRun, runs_json
from q2q_sim.tools.demo.demo_flights import fly_requests, print_numbers
from q2q_sim.tools.demo.real_flight_page import write_real_page
from q2q_sim.tools.fly_scenario import print_flights as print_runs
from q2q_sim.tools.fly_scenario import print_verdict

PASSAGE = "table6_room"
MODES = ("ignoring", "aware")
STACKED = "*_ss*"
"""Files of flights of two or three vehicles."""
PUBLIC = "https://github.com/aerorobotics/neural-swarm (docs/real_flights.md)"
"""Where recorded flights of stacked Crazyflies are found."""
SIMULATED = (
    "The flights used here are the simulated ones of bags/, whose downwash is several times weaker than that "
    "of real Crazyflies: in the room's air, their model helps little."
)
SHIPPED_BAGS = Path(__file__).resolve().parents[5] / "bags"


@dataclass(frozen=True, slots=True)
class DemoFlights:
    """Flights of the demonstration."""

    training: tuple[Path, ...]
    """Flights that the model is fitted to; each is scored by a model of the others."""
    further: tuple[Path, ...]
    """Flights that are scored alone."""
    origin: str
    """What they are, in one sentence."""


@dataclass(frozen=True, slots=True)
class DemoScores:
    """Scores of the flights of the demonstration."""

    held_out: HeldOutScores
    fit: Fit
    """Flights that the model is fitted to."""


def run(args: Namespace) -> int:
    """Fit, score, fly and write the page; return the exit status."""
    flights = find_flights(args.real)
    _print_note(flights.origin)
    with threadpool_limits(1, user_api="blas"):  # more threads are slower on small matrices
        scored = score_flights(flights)
    scores = scored.held_out
    _print_scores(scores)
    model = _save_model(ModelFile(scores.jet, fit=scored.fit), args.out)
    requests = [FlightRequest(PASSAGE, mode, model=str(model), air=ROOM, stack=True) for mode in MODES]
    runs = fly_requests(requests, args.out)
    if args.json:
        write_json(_as_json(flights, scores, runs), args.json)
    print_runs(runs)
    print_numbers(runs)
    write_real_page(flights.origin, scores, runs, args.out)
    return print_verdict(runs)


def find_flights(given: Sequence[Path]) -> DemoFlights:
    """Return the given flights, else those of Q2Q_DATA, else the simulated ones of the checkout.

    Raises:
        ValueError: there are none.
    """
    if given:
        return DemoFlights(tuple(given), (), f"The flights are {', '.join(map(str, given))}.")
    folder = flights_folder().resolve()
    flown_in = {_family(name) for name in load(air_path(ROOM)).flights}
    found = sorted(folder.glob(STACKED))
    training = tuple(one for one in found if _family(one.stem) not in flown_in)
    further = tuple(one for one in found if one not in training)
    if training:
        return DemoFlights(training, further, f"The flights are {len(found)} real ones of {folder}.")
    shipped = tuple(sorted(SHIPPED_BAGS.glob("table2_*")))
    absent = f"There are no recorded real flights in {folder} (Q2Q_DATA); public ones: {PUBLIC}."
    if not shipped:
        raise ValueError(f"{absent} Give your own: scripts/demo --real FLIGHT...")
    return DemoFlights(shipped, (), f"{absent} {SIMULATED}")


def _family(flight: str) -> str:
    return flight.partition("_")[0]


def score_flights(flights: DemoFlights) -> DemoScores:
    """Return the model of the training flights, and the scores of all flights without it."""
    vehicle = vehicle_of_flights(flights.training).vehicle
    _print_note(f"pushes missing in logs are computed for a {vehicle.name} of {1e3 * vehicle.mass:.0f} g")
    training, digests = _samples(flights.training, vehicle)
    further, _ = _samples(flights.further, vehicle) if flights.further else ({}, {})
    scores = held_out_scores(training, further)
    scored = {one.name for one in scores.flights}
    for name in (one for one in (*training, *further) if one not in scored):
        _print_note(f"{name} is not scored: no vehicle under another with {FEWEST_FREE} samples in clear air")
    names = tuple(sorted({name for one in scores.flights for name in one.fitted_to}))
    method = "jet fitted to measured downwash"
    return DemoScores(scores, Fit(method, names, digests=tuple(digests[name] for name in names)))


def _samples(paths: Sequence[Path], vehicle: Vehicle) -> tuple[dict[str, list[PushSamples]], dict[str, str]]:
    """Return the samples of every flight with a measured push, and the digests of all flights."""
    recordings, notes = recordings_of_paths(paths)
    records = {one.flight.name: push_record(one, vehicle, vehicle.thrust_lag) for one in recordings}
    unmeasured = [f"{name} has no measured push: left out" for name, one in records.items() if one is None]
    for note in (*notes, *unmeasured):
        _print_note(note)
    samples = {name: push_samples(one) for name, one in records.items() if one is not None}
    return samples, {one.flight.name: flight_digest(one.flight) for one in recordings}


def _save_model(model: ModelFile, out: Path) -> Path:
    path = out / "model.q2q"
    save(path, model)
    print(f"model: {path}")
    return path


def _print_scores(scores: HeldOutScores) -> None:
    for one in scores.flights:
        print(f"{one.name:32} R2 {one.score.r2_exposed:6.3f}, n {one.score.n}, left out of the fit")
    together = scores.together
    print(f"{'all':32} R2 {together.r2_exposed:6.3f}, n {together.n}")


def _as_json(flights: DemoFlights, scores: HeldOutScores, runs: Sequence[FlightRun]) -> dict[str, object]:
    held_out = {one.name: {**asdict(one.score), "fitted_to": one.fitted_to} for one in scores.flights}
    together = asdict(scores.together)
    return {
        "origin": flights.origin,
        "held_out": {"flights": held_out, "pooled": together},
        "flown": runs_json(runs),
    }


def _print_note(words: str) -> None:
    print(f"demo: {words}", file=sys.stderr, flush=True)
