"""Replay page of bags and tables."""

import sys
from argparse import Namespace
from collections.abc import Collection
from pathlib import Path

import numpy as np

from q2q_model.bag import BagReader, FlightFacts, TopicMap, read_facts
from q2q_model.documents.written_file import write_text
from q2q_model.flights.flight import Flight, of_rows
from q2q_model.flights.tables.table_file import TABLES
from q2q_model.flights.units_and_frames.frame_notes import frame_notes
from q2q_model.identification.push.push_samples import PushRecord
from q2q_model.identification.push.recorded_push import check_weight, push_record
from q2q_model.recordings.bag_vehicle import FlownVehicle, flown_vehicle
from q2q_model.recordings.flight_recording import Recording
from q2q_model.recordings.recording_reader import recording_of_bag, recording_of_table
from q2q_model.recordings.recordings_of_bags import topic_map
from q2q_model.vehicle.constants import DEFAULT_VEHICLE, Vehicle, vehicle_by_name
from q2q_sim.flight_bag.scenario_facts import flown_faults
from q2q_sim.monitors.flight_judgement import verdict_of
from q2q_sim.monitors.policies import Circumstances
from q2q_sim.monitors.recording_end import with_end
from q2q_sim.replay_page import MOST_RUNS, ReplayRun, in_air, replay_html, replay_run, with_measured_downwash
from q2q_sim.tools.distinct_names import distinct_names


def run(args: Namespace) -> int:
    """Write the page of the named flights; return the exit status."""
    if len(args.flights) > MOST_RUNS:
        raise ValueError(f"{len(args.flights)} flights; must be at most {MOST_RUNS} side by side")
    topics, names = topic_map(args.topics), distinct_names(args.flights)
    runs = [_run_of(path, name, args, topics) for path, name in zip(args.flights, names, strict=True)]
    html = replay_html(runs, args.title or " and ".join(one.name for one in runs))
    write_text(html, args.out)
    for one in runs:
        if one.missing:
            print(f"replay_page: {one.name} does not record {', '.join(one.missing)}", file=sys.stderr)
        print(f"{one.name}: {one.verdict}")
    print(f"page: {args.out} ({args.out.stat().st_size / 1e6:.2f} MB)")
    return 0


def _run_of(path: Path, name: str, args: Namespace, topics: TopicMap | None) -> ReplayRun:
    is_table = path.suffix in TABLES and path.is_file()
    recording = recording_of_table(path) if is_table else recording_of_bag(path, topics)
    flown = _vehicle(path, args.vehicle, is_table=is_table)
    whole = recording.flight
    notes = [note for note in (flown.note, *frame_notes(whole)) if note]
    for note in notes:
        print(f"replay_page: {note}", file=sys.stderr)
    check_weight(whole, flown.vehicle)
    part = part_of_flight(whole, args.start, args.end)
    around = Circumstances(vehicle=flown.vehicle, faults=flown_faults(path))
    verdict = verdict_of(part, around, whole=whole)
    facts = FlightFacts() if is_table else read_facts(path)
    if part.t[-1] == whole.t[-1] and not is_table:
        verdict = with_end(verdict, whole, facts.duration, is_cut=BagReader(path).is_cut)
    run = in_air(replay_run(part, flown.vehicle, name, verdict, whole), facts.flown_air)
    return with_measured_downwash(run, lambda: measured_push(recording, flown.vehicle, notes))


def measured_push(recording: Recording, vehicle: Vehicle, said: Collection[str] = ()) -> PushRecord | None:
    """Return a flight's measured push; None, with a note, if it is not that of the vehicle.

    The reason is left out of the note if it was `said` before.
    """
    try:
        return push_record(recording, vehicle, vehicle.thrust_lag)
    except ValueError as unfit:
        why = "" if str(unfit) in said else f": {unfit}"
        print(f"replay_page: no downwash is shown{why}", file=sys.stderr)
        return None


def _vehicle(path: Path, override: str, *, is_table: bool) -> FlownVehicle:
    if not is_table:
        return flown_vehicle(path, override)
    return FlownVehicle(vehicle_by_name(override or DEFAULT_VEHICLE))


def part_of_flight(flight: Flight, start: float, end: float | None) -> Flight:
    """Return a flight from `start` to `end` [s] after its first tick; raise ValueError if that is empty."""
    since = flight.t - flight.t[0]
    kept = (since >= start) & (since <= (np.inf if end is None else end))
    if kept.sum() < 2:
        asked = f"--start {start:g}" + ("" if end is None else f" --end {end:g}")
        raise ValueError(f"{asked} keeps nothing: flight {flight.name} lasts 0 to {since[-1]:.2f} s")
    return of_rows(flight, kept)
