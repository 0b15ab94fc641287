"""Flights of encounters, spread over processes: what the command `promise` flies, prints and writes."""

import sys
from argparse import Namespace
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial

from rich.console import Console
from rich.progress import track

from q2q_model.documents.json_file import Json, write_json
from q2q_model.documents.plain_values import to_plain
from q2q_sim.experiments.promise.kept_flights import resume_flights
from q2q_sim.experiments.promise.promise_verdict import (
    largest_errors,
    promise_verdict,
    verdict_json,
    verdict_lines,
)
from q2q_sim.experiments.promise.room_encounter import (
    STEADY,
    EncounterRecord,
    PromiseCase,
    fly_room_encounter,
)
from q2q_sim.experiments.promise.tracking_tube import (
    TrackingTube,
    TubeFlights,
    check_enough_flights,
    learn_tube,
    read_tube,
)
from q2q_sim.experiments.promise.tube_report import different_conditions, reused_seeds, tube_lines
from q2q_sim.processes.parallel_work import Workers, spread_work


def run(args: Namespace) -> int:
    """Fly the encounters of the command line; return 1 if a vehicle entered a zone under the conditions."""
    if args.learn:
        check_enough_flights(args.count, args.alpha)
    tube = read_tube(args.tube) if args.tube else None
    case = promise_case(args, tube)
    if tube:
        _warn(tube, case, args)
    records = _flown(range(args.first, args.first + args.count), case, args)
    found = promise_verdict(records, tube)
    document: dict[str, Json] = {"first": args.first, "verdict": verdict_json(found)}
    document["replanner"] = to_plain(case.params)
    document["tube"] = to_plain(tube) if tube else None
    if args.json:
        write_json(document, args.json)
    print(*verdict_lines(found), sep="\n")
    if args.learn:
        flown = TubeFlights(args.first, args.count, case.params.tracking, case.params.tracking_z)
        learned = learn_tube(largest_errors(records), args.alpha, case.conditions, flown)
        write_json(to_plain(learned), args.learn)
        print(*tube_lines(learned), sep="\n")
    return int(found.entries.events > 0)


def _warn(tube: TrackingTube, case: PromiseCase, args: Namespace) -> None:
    """Print in what the flights are not fresh ones of those that the tube is learned from."""
    for difference in different_conditions(tube, case.conditions):
        print(f"promise: not the flights of the tube: {difference}", file=sys.stderr)
    reused = reused_seeds(tube, args.first, args.count)
    if reused:
        print(f"promise: {reused}", file=sys.stderr)


def promise_case(args: Namespace, tube: TrackingTube | None) -> PromiseCase:
    """Return what is flown: the first guess of a tube, or the given one."""
    jerk = STEADY.jerk_max if args.jerk is None else args.jerk
    params = replace(STEADY, jerk_max=jerk)
    if tube is not None:
        params = replace(params, tracking=tube.horizontal, tracking_z=tube.vertical)
    return PromiseCase(params, args.controller, args.air)


def _flown(seeds: Sequence[int], case: PromiseCase, args: Namespace) -> list[EncounterRecord]:
    fly = partial(_spread, case=case, jobs=args.jobs)
    runs = resume_flights(seeds, case, args.keep, fly) if args.keep else fly(seeds)
    shown = track(runs, "promise", total=len(seeds), console=Console(stderr=True), transient=True)
    return sorted(shown, key=lambda one: one.seed)


def _spread(seeds: Sequence[int], case: PromiseCase, jobs: int) -> Iterator[EncounterRecord]:
    return spread_work(Workers("local", jobs), partial(_fly, case=case), seeds, _died)


def _fly(seed: int, case: PromiseCase) -> EncounterRecord:
    """Return the record of an encounter; an error names its seed."""
    try:
        return fly_room_encounter(seed, case)
    except Exception as error:
        raise RuntimeError(f"encounter {seed}: {error}") from error


def _died(seed: int) -> EncounterRecord:
    """Raise ChildProcessError: the process died."""
    raise ChildProcessError(f"encounter {seed}: its process died when flown alone")
