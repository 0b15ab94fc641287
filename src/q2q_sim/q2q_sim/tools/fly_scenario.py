"""Flight of one scenario from the command line, with progress, table and verdict."""

import sys
import tempfile
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path

from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

from q2q_model.documents.json_file import write_json
from q2q_model.plain_console import plain_console
from q2q_model.vehicle.constants import Vehicle, firmware_of
from q2q_sim.faults.faults import late_fault_notes
from q2q_sim.node_flights.controller_errors import controller_errors
from q2q_sim.node_flights.flight_request import FlightRequest, load_scenario
from q2q_sim.node_flights.flight_run import FlightRun, runs_json
from q2q_sim.node_flights.scenario_flight import MEASURED, fly_through_nodes
from q2q_sim.node_flights.unfinished_bag import recorder_notes
from q2q_sim.processes.interruption import Interruption
from q2q_sim.report.run_table import mode_words, run_notes, run_table, run_verdicts
from q2q_sim.scenarios import library


def run(args: Namespace) -> int:
    """Fly, print and write the results; return the exit status."""
    if args.list:
        width = max(map(len, library.names()))
        for name in library.names():
            print(f"{name:{width}}  {library.describe(name)}")
        return 0
    if args.real:
        from q2q_sim.tools.replay_recorded_flight import replay_recorded_flight

        return replay_recorded_flight(args.real, args.model, args.json)
    flown = _fly(args)
    try:
        if args.json:  # first: the table may have no reader
            write_json(runs_json([flown]), args.json)
    finally:
        print_flights([flown])
        status = print_verdict([flown])
    return status


def print_verdict(runs: Sequence[FlightRun]) -> int:
    """Print the verdict on some flights as the last line; return the exit status, 1 if one is not ok."""
    print(run_verdicts(runs))
    return int(not all(run.verdict.ok for run in runs))


def print_flights(runs: Sequence[FlightRun]) -> None:
    """Print the table of some flights, and their timing."""
    console = plain_console()
    console.print(run_table(runs, console.width))
    for note in run_notes(runs):
        console.print(note)


def request_of(args: Namespace) -> FlightRequest:
    """Return the requested flight."""
    mode = "ignoring" if not args.aware else "aware" if args.limit else "aware_unlimited"
    return FlightRequest(
        scenario=args.scenario,
        mode=mode,
        controller=args.controller,
        replan=args.replan,
        plan=args.plan,
        live=args.live,
        stack=not args.live if args.stack is None else args.stack,
        distributed=args.distributed,
        seed=args.seed,
        model=args.model,
        vehicle=args.vehicle,
        wake=args.wake,
        air=args.air,
        air_without=tuple(args.air_without),
        correct=args.correct,
        record=tuple(dict.fromkeys((*MEASURED, *args.record))) if args.record or not args.bag else (),
        temporary=args.bag is None,
    )


def vehicle_change(own: Vehicle, flown: Vehicle) -> str:
    """Return the flown vehicle as text, with the scenario's own one that it replaces."""
    if flown.name != own.name:
        return f"{flown.name}, not {own.name}"
    return f"{flown.name} with firmware {firmware_of(flown)}, not {firmware_of(own)}"


def scenario_notes(request: FlightRequest) -> list[str]:
    """Return what is flown otherwise than the scenario or a reader of its file expects, one line each."""
    own, flown = library.load(request.scenario), load_scenario(request)
    notes = late_fault_notes(flown.faults, flown.duration)
    if not (request.wake or request.air):
        notes = [*library.replaced_by_air(request.scenario), *notes]
    if flown.vehicle != own.vehicle and not request.vehicle:
        change = vehicle_change(own.vehicle, flown.vehicle)
        notes = [f"in air {request.air} by {change} (`in_air` of the scenario)", *notes]
    return notes


def _fly(args: Namespace) -> FlightRun:
    request = request_of(args)
    for note in scenario_notes(request):
        print(f"fly: {request.scenario}: {note}", file=sys.stderr)
    interruption = Interruption()
    with tempfile.TemporaryDirectory(prefix="q2q-fly-") as scratch:
        bag = args.bag or Path(scratch) / "bag"
        return fly_with_progress(request, Path(scratch) / "nodes", bag, interruption)


def fly_with_progress(
    request: FlightRequest, folder: Path, bag: Path, interruption: Interruption
) -> FlightRun:
    """Fly with a progress bar on the terminal; a signal ends the flight."""
    words = TextColumn("{task.description}", markup=False)
    columns = words, BarColumn(), TaskProgressColumn(), TimeRemainingColumn()
    with Progress(*columns, console=plain_console(stderr=True)) as bar:
        task = bar.add_task(f"{request.scenario} {mode_words(request)}", total=1.0)

        def follow(share: float) -> None:
            interruption.check()
            bar.update(task, completed=share)

        def print_wait(text: str) -> None:
            bar.console.print(f"fly: {request.scenario}: {text}", soft_wrap=True)

        run = fly_through_nodes(request, folder, bag, follow, print_wait)
        bar.update(task, completed=1.0)
    for note in (*controller_errors(folder), *recorder_notes(folder)):
        print(note, file=sys.stderr)
    return run
