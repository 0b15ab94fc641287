"""Scores of an interaction model on recorded flights, separate and pooled."""

import sys
from argparse import Namespace
from collections.abc import Sequence
from dataclasses import asdict

from q2q_model.documents.json_file import write_json
from q2q_model.flights.duplicates.same_flight import fit_remarks
from q2q_model.flights.units_and_frames.frame_notes import axis_notes
from q2q_model.identification.push.log_check import log_notes
from q2q_model.identification.push.log_column_note import log_column_notes
from q2q_model.identification.push.push_samples import (
    APART,
    FEWEST_FREE,
    FLOOR,
    PushSamples,
    PushScore,
    push_samples,
    score,
    unmeasured_note,
)
from q2q_model.identification.push.rate_check import rate_notes
from q2q_model.identification.push.recorded_push import lag_note, push_record
from q2q_model.identification.push.sensor_check import sensor_notes
from q2q_model.model_files.find_model import find_model
from q2q_model.model_files.model_file import Fit
from q2q_model.recordings.bag_vehicle import common_vehicle
from q2q_model.recordings.flight_recording import Recording
from q2q_model.recordings.recordings_of_bags import bags_among, recordings_of_bags, topic_map
from q2q_model.vehicle.constants import Vehicle


def run(args: Namespace) -> int:
    """Score a model, print and write the scores, and return the exit status."""
    model = find_model(args.model)
    law = model.interaction
    bags, left_out = bags_among(args.bags)
    recordings, repairs = recordings_of_bags(bags, topic_map(args.topics))
    flown = common_vehicle(bags, args.vehicle)
    samples = _samples(recordings, flown.vehicle)
    scores = {name: score(law, found) for name, found in samples.items()}
    pooled = score(law, [one for found in samples.values() for one in found])
    fit = model.fit or Fit("", ())
    in_fit = fit_remarks((one.flight for one in recordings), fit.flights, fit.digests)
    text = {
        "thrust_lag_s": flown.vehicle.thrust_lag,
        "flights": {name: asdict(one) | {"in_fit": name in in_fit} for name, one in scores.items()},
        "pooled": asdict(pooled),
    }
    if args.json:
        write_json(text, args.json)
    notes = [*left_out, *filter(None, [flown.note]), *(f"repaired: {repair}" for repair in repairs)]
    flights = [one.flight for one in recordings]
    notes += [note for flight in flights for note in axis_notes(flight)]
    notes += sensor_notes(flights, flown.vehicle) + rate_notes(flights)
    notes += log_column_notes(recordings, flown.vehicle) + log_notes(recordings, flown.vehicle)
    notes += lag_note([one for one in recordings if samples[one.flight.name]], flown.vehicle.thrust_lag)
    for note in notes:
        print(f"evaluate: {note}", file=sys.stderr)
    for name, one in scores.items():
        print(", ".join([_line(name, one), *filter(None, [in_fit.get(name)])]))
    print(_line("pooled", pooled))
    return 0


def _samples(recordings: Sequence[Recording], vehicle: Vehicle) -> dict[str, list[PushSamples]]:
    found: dict[str, list[PushSamples]] = {}
    measured = False
    for one in recordings:
        record = push_record(one, vehicle, vehicle.thrust_lag)
        if record is None:
            print(f"evaluate: {one.flight.name} has no measured push: not scored", file=sys.stderr)
        elif note := unmeasured_note(record):
            print(f"evaluate: {note}", file=sys.stderr)
        measured = measured or record is not None
        found[one.flight.name] = [] if record is None else push_samples(record)
    if not measured:
        raise ValueError(
            "no flight has a measured push: record imu and command, or a log with faz_est, gap and pwm1-4"
        )
    if not any(found.values()):
        raise ValueError(
            f"no vehicle has {FEWEST_FREE} measured rows in clear air: above {FLOOR} m, no motor saturated, "
            f"no vehicle above or below within {APART} m horizontally"
        )
    return found


def _line(name: str, one: PushScore) -> str:
    if one.rmse_exposed_mps2 is None:
        return f"{name:32} no sample lies under another vehicle"
    r2 = "undefined" if one.r2_exposed is None else f"{one.r2_exposed:6.3f}"
    upper = "" if one.mean_upper_mps2 is None else f", upper {one.mean_upper_mps2:+.3f} m/s^2"
    ahead = "" if one.r2_ahead_20ms is None else f", 20 ms ahead {one.r2_ahead_20ms:.3f}"
    rmse = f"rmse {one.rmse_exposed_mps2:.3f} m/s^2"
    return f"{name:32} R2 {r2}{ahead}, {rmse}, {one.n} rows{upper}"
