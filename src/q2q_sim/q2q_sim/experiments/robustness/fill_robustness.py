"""Missing flights of the robustness table, and its page."""

import json
import math
import shlex
from argparse import Namespace
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from rich.progress import track

from q2q_model.documents.json_file import with_nulls
from q2q_model.documents.written_file import write_text
from q2q_sim.experiments.robustness.perturbations import PERTURBATIONS
from q2q_sim.experiments.robustness.perturbed_flight import Errors, PerturbedFlight, fly_perturbed
from q2q_sim.experiments.robustness.robustness_page import flight_key, ignoring_flight, page
from q2q_sim.processes.resume_log import exclusive_file
from q2q_sim.scenarios.choices import TABLE_ONLY

CONTROLLERS = ("mpc", "pid")
DRAWS = "draws and seed"
"""Key of the draws in a file of numbers."""
FLOWN = "flown"
"""Key of when, and by which commits, they were flown, if that was noted; the other keys are flights."""


class FlightDraws(NamedTuple):
    """Draws of every flight in a file."""

    each: int
    """Number in each flight."""
    seed: int
    """Of the flight that holds them side by side."""


class KeptNumbers(NamedTuple):
    """Numbers of flights in a file."""

    errors: Mapping[str, Errors]
    draws: FlightDraws
    flown: str = ""
    """When, and by which commits; empty if that was not noted."""


def run(given: Namespace) -> int:
    """Fly what is missing, keep the numbers after each flight, write the page; return the exit status."""
    flights = asked_flights(given.airs, given.draws, given.seed)
    if given.table_only:
        kept = _present(given)
    else:
        with exclusive_file(given.json):
            kept = _filled(flights, given)
    found = kept.errors
    complete = [
        one for one in flights if flight_key(one) in found and flight_key(ignoring_flight(one)) in found
    ]
    if not complete:
        raise ValueError(f"{given.json} holds none of these flights: leave out {TABLE_ONLY}")
    words = [word for word in given.argv if word != TABLE_ONLY]
    command = f"ros2 run q2q_sim robustness {shlex.join(words)}"
    write_text(page(found, complete, command, kept.flown), given.out)
    print(f"page: {given.out}\nnumbers: {given.json}")
    return 0


def _present(given: Namespace) -> KeptNumbers:
    """Return the numbers in the file, none without one; raise ValueError if they are of other draws."""
    asked = FlightDraws(given.draws, given.seed)
    if not given.json.is_file():
        return KeptNumbers({}, asked)
    kept = read(given.json)
    if kept.draws != asked:
        raise ValueError(
            f"{given.json} was made with --draws {kept.draws.each} --seed {kept.draws.seed}: give these, "
            "or another file"
        )
    return kept


def _filled(flights: Sequence[PerturbedFlight], given: Namespace) -> KeptNumbers:
    """Return the numbers in the file and those of missing flights, which are added to it."""
    kept = _present(given)
    found = dict(kept.errors)
    wanted = {
        flight_key(one): one for pair in ((ignoring_flight(one), one) for one in flights) for one in pair
    }
    missing = [name for name in wanted if name not in found]
    for name in track(missing, "flights"):
        found[name] = fly_perturbed(wanted[name])
        save(kept._replace(errors=found), given.json)
    return kept._replace(errors=found)


def asked_flights(airs: Sequence[str], draws: int, seed: int) -> list[PerturbedFlight]:
    """Return the corrected flights of all perturbations in all airs."""
    return [
        PerturbedFlight(air, one, controller, corrects=True, draws=draws, seed=seed)
        for controller in CONTROLLERS
        for air in airs
        for one in PERTURBATIONS
    ]


def read(file: Path) -> KeptNumbers:
    """Return the numbers in a file.

    Raises:
        ValueError: the file has another form.
    """
    try:
        body = json.loads(file.read_text(encoding="utf-8"))
        draws = FlightDraws(*body.pop(DRAWS))
        flown = str(body.pop(FLOWN, ""))
        errors = {str(name): Errors(*map(_error, row)) for name, row in body.items()}
        return KeptNumbers(errors, draws, flown)
    except (AttributeError, KeyError, TypeError, ValueError, RecursionError) as wrong:
        raise ValueError(
            f"{file} has no results of flights ({wrong}): remove it, or give another file"
        ) from wrong


def _error(number: float | None) -> float:
    return math.nan if number is None else float(number)


def save(numbers: KeptNumbers, file: Path) -> None:
    """Replace a file by these numbers [m], null if unknown, a line for each flight after their draws."""
    rows = [f" {json.dumps(DRAWS)}: {json.dumps(numbers.draws)}"]
    if numbers.flown:
        rows.append(f" {json.dumps(FLOWN)}: {json.dumps(numbers.flown)}")
    rows += [
        f" {json.dumps(name)}: {json.dumps(with_nulls([float(f'{x:.5g}') for x in errors]))}"
        for name, errors in numbers.errors.items()
    ]
    write_text("{\n" + ",\n".join(rows) + "\n}\n", file)
