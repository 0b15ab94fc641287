"""Learning of a room's air from recorded flights, with progress bar, table and JSON."""

import sys
import time
from argparse import Namespace
from dataclasses import asdict, replace

from threadpoolctl import threadpool_limits

from q2q_model.counted import counted
from q2q_model.documents.json_file import write_json
from q2q_model.flights.units_and_frames.frame_notes import axis_notes
from q2q_model.identification.push.log_check import log_notes
from q2q_model.identification.push.rate_check import rate_notes
from q2q_model.identification.push.sensor_check import sensor_notes
from q2q_model.recordings.recordings_of_bags import topic_map
from q2q_model.recordings.recordings_of_paths import recordings_of_paths
from q2q_model.recordings.vehicle_of_flights import vehicle_of_flights
from q2q_sim.air.air_file import save
from q2q_sim.air.learning.learned_air import LearnedAir, learn_air
from q2q_sim.air.learning.statistics.fitted import Fitted


def run(args: Namespace) -> int:
    """Learn an air, write and print it, and return the exit status."""
    began = time.process_time()
    recordings, notes = recordings_of_paths(args.flights, topic_map(args.topics))
    flown = vehicle_of_flights(args.flights, args.vehicle)
    with threadpool_limits(1, user_api="blas"):  # more threads are slower on small matrices
        found = learn_air(recordings, flown.vehicle, _print_step)
    save(args.out, found.air)
    flights = [one.flight for one in recordings]
    doubts = [note for flight in flights for note in axis_notes(flight)]
    doubts += (
        sensor_notes(flights, flown.vehicle) + rate_notes(flights) + log_notes(recordings, flown.vehicle)
    )
    found = replace(found, notes=(*doubts, *found.notes))
    if args.json:
        write_json(_as_json(found, time.process_time() - began), args.json)
    for note in (*notes, *filter(None, [flown.note]), *found.notes):
        print(f"learn_air: {note}", file=sys.stderr)
    print(table(found))
    used = counted(len(found.air.flights), "flight")
    print(f"air: {args.out}, {used}, {time.process_time() - began:.0f} s of CPU")
    return 0


def _print_step(step: str) -> None:
    print(f"learn_air: {step} ...", file=sys.stderr)


def table(found: LearnedAir) -> str:
    """Return learned values, intervals, rows and sources as a table, with a verdict on the checks."""
    head = f"{'term':32}{'value':>9}  {'95 % interval':^19}{'rows':>8}  from"
    verdict = found.doubts or (("all are as expected",) if found.checks else ())
    checks = [*map(_line, found.checks), *(f"verdict: {one}" for one in verdict)]
    return "\n".join([head, *map(_line, found.values), *(["checks:", *checks] if checks else [])])


def _line(one: Fitted) -> str:
    known = one.low is not None and one.high is not None
    ends = f"{one.low:8.4g} to {one.high:<8.4g}" if known else "-"
    return f"{one.path:32}{one.value:9.4g}  {ends:^19} {one.rows or '-':>8}  {one.source}"


def _as_json(found: LearnedAir, seconds: float) -> dict[str, object]:
    return {
        "flights": list(found.air.flights),
        "values": {one.path: asdict(one) for one in found.values},
        "checks": {one.path: asdict(one) for one in found.checks},
        "notes": list(found.notes),
        "doubts": list(found.doubts),
        "cpu_s": seconds,
    }
