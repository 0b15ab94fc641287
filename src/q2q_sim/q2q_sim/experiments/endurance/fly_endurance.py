"""Long flight from the command line: flown, watched, reported."""

from argparse import Namespace
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

from rich.progress import Progress

from q2q_model.documents.json_file import write_json
from q2q_model.plain_console import plain_console
from q2q_sim.experiments.endurance.endurance_report import (
    endurance_json,
    endurance_sentence,
    growth_table,
    is_flat,
    measured_growths,
)
from q2q_sim.experiments.endurance.long_flight import LongFlight, fly_long, write_long_scenario
from q2q_sim.node_flights.flight_request import FlightRequest
from q2q_sim.processes.interruption import Interruption

WIDTH = 110
"""Of the table, at least."""


def run(args: Namespace) -> int:
    """Fly, print and write the growth of every quantity; return the exit status."""
    flight = _flown(args)
    found = measured_growths(flight)
    if args.json:
        write_json(endurance_json(flight, found), args.json)
    console = plain_console()
    console.print(growth_table(flight, found), width=max(console.width, WIDTH))
    print(endurance_sentence(flight, found))
    return int(not is_flat(flight, found))


def _flown(args: Namespace) -> LongFlight:
    interruption = Interruption()
    with (
        TemporaryDirectory(prefix="q2q-endurance-") as place,
        Progress(console=plain_console(stderr=True)) as bar,
    ):
        task = bar.add_task("endurance", total=1.0)

        def follow(share: float) -> float:
            interruption.check()
            bar.update(task, completed=share)
            return perf_counter()

        scenario = write_long_scenario(Path(place), args.vehicles, 60.0 * args.minutes)
        request = FlightRequest(str(scenario), live=args.live, stack=not args.live)
        return fly_long(request, args.vehicles, Path(place) / "flight", follow)
