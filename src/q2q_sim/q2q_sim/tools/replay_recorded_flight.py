"""Replay of a real recorded flight: its mocap through the nodes of filter and interference, and model score.

The observed downwash is the vertical push in the flight's log by
q2q_model.identification.push.push_samples; the predicted one is the output of the node `interference`.
"""

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from q2q_model.bag import read_flight_log
from q2q_model.documents.json_file import write_json
from q2q_model.flights.flight_log import log_at
from q2q_model.flights.tables.flight_table import flight_table
from q2q_model.flights.tables.table_file import read_columns
from q2q_model.identification.push.along_flight import Motion
from q2q_model.identification.push.log_mass import log_masses
from q2q_model.identification.push.push_samples import (
    PushSamples,
    PushScore,
    pooled_score,
    push_samples,
)
from q2q_model.identification.push.recorded_push import motion_of, push_of_log
from q2q_model.recordings.recording_reader import flight_of_bag
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import DEFAULT_VEHICLE, vehicle_by_name
from q2q_sim.air.air_names import flight_path
from q2q_sim.node_flights.nodes_on_bag import replay
from q2q_sim.report.panels import save
from q2q_sim.report.prediction_figure import PredictedPush, prediction_figure
from q2q_sim.tools.import_table import write_bag

DEFAULT_MODEL = "measured_law"
OUT = Path("out/real")


def replay_recorded_flight(name: str, model: str, json_file: Path | None) -> int:
    """Replay a real flight, print and draw the prediction of its downwash; return the exit status."""
    chosen = model or DEFAULT_MODEL
    table = flight_table(read_columns(flight_path(name)))
    with TemporaryDirectory(prefix="q2q-real-") as scratch:
        bag = Path(scratch) / name
        write_bag(table, bag)
        flight = replay(bag, chosen, Path(scratch) / "nodes")
        recorded, log = flight_of_bag(bag), read_flight_log(bag)
    at = np.searchsorted(flight.t, log.t)
    seen = motion_of(flight)
    motion = Motion(log.t, seen.pos[at], seen.vel[at], seen.axis[at])
    masses = log_masses(log_at(log, recorded.t, recorded.names), recorded, vehicle_by_name(DEFAULT_VEHICLE))
    samples = push_samples(push_of_log(name, log_at(log, log.t, flight.names), motion, masses))
    found = score_prediction(samples, flight.eta[at, :, 2])
    pushes = [
        PredictedPush(flight.names[one.vehicle], log.t, one.y, one.exposed, flight.eta[at, one.vehicle, 2])
        for one in samples
    ]
    picture = save(prediction_figure(pushes), OUT / f"{name}.png")
    if json_file:
        write_json({"flight": name, "model": chosen, **asdict(found)}, json_file)
    print_score(name, chosen, found)
    print(f"plot: {picture}")
    return 0


def score_prediction(samples: Sequence[PushSamples], eta_z: Array) -> PushScore:
    """Score predicted vertical downwash [m/s^2], (T, n), as published by the node."""
    y = [one.y[one.exposed] for one in samples]
    residuals = [one.y[one.exposed] - eta_z[one.exposed, one.vehicle] for one in samples]
    return pooled_score(y, residuals, samples)


def print_score(name: str, model: str, found: PushScore) -> None:
    """Print the score."""
    if found.r2_exposed is None or found.rmse_exposed_mps2 is None:
        print(f"{name}: no sample lies under another vehicle; nothing to score")
        return
    print(f"{name}, model {model}, {found.n} samples under another vehicle:")
    print(f"  R2 {found.r2_exposed:.3f}, rmse {found.rmse_exposed_mps2:.3f} m/s^2")
    if found.mean_upper_mps2 is not None:
        print(f"  upper vehicles feel {found.mean_upper_mps2:+.3f} m/s^2 in the mean")
