"""Validation of an air by recorded flights: what is flown, reported, drawn and written."""

import sys
from argparse import Namespace
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from q2q_model.documents.json_file import write_json
from q2q_model.flights.duplicates.same_flight import fit_remarks
from q2q_model.identification.push.log_column_note import log_column_notes
from q2q_model.identification.push.push_samples import FEWEST_FREE
from q2q_model.recordings.flight_recording import Recording
from q2q_model.vehicle.constants import Vehicle
from q2q_sim.air.lookup.find_air import FlownAir
from q2q_sim.air.room_air import RoomAir
from q2q_sim.experiments.validation.drawn_air import draws_in
from q2q_sim.experiments.validation.error_statistics import Comparison, comparison
from q2q_sim.experiments.validation.flight_alone import (
    ComparedAlone,
    FlightAlone,
    compared_alone,
    flight_alone,
    is_alone,
)
from q2q_sim.experiments.validation.recorded.tracked_flight import TrackedFlight, tracked_flight
from q2q_sim.experiments.validation.validated_flight import (
    ValidatedFlight,
    as_json,
    pooled_comparison,
    validate_flight,
    validation_sentence,
)
from q2q_sim.experiments.validation.validation_page import write_page
from q2q_sim.plant.room_vehicle import vehicle_of_room


def validate(recordings: Sequence[Recording], vehicle: Vehicle, air: FlownAir, args: Namespace) -> int:
    """Fly the recordings again, print, draw and write the numbers; return the exit status."""
    tracked, single = _flyable(recordings, vehicle)
    known = air if isinstance(air, RoomAir) else RoomAir()
    in_fit = fit_remarks((one.flight for one in recordings), known.flights, known.digests)
    notes = [f"{name}: {remark}" for name, remark in in_fit.items()] + log_column_notes(recordings, vehicle)
    for note in notes:
        _say(note)
    done = _all_flown(tracked, air, vehicle, args.draws, only=len(recordings) == 1)
    if not done and not single:
        raise ValueError(f"none of the {len(recordings)} flights can be flown again")
    alone = [_flown_alone(one, air, vehicle, args.draws) for one in single]
    notes += [note for one in done for note in _flight_notes(one)]
    if args.json:
        write_json(as_json(done, alone, tuple(in_fit), notes), args.json)
    if args.out:
        print(f"page: {write_page(done, alone, Path(args.air).name, args.out, notes)}")
    if alone:
        print(_line("all alone, height", comparison([one.vertical for one in alone])))
        print(_line("all alone, x and y", comparison([one.lateral for one in alone])))
    print(_line("all, under a wake", pooled_comparison(done)))
    print(validation_sentence(pooled_comparison(done)))
    return 0


def _flyable(
    recordings: Sequence[Recording], vehicle: Vehicle
) -> tuple[list[TrackedFlight], list[FlightAlone]]:
    """Return the flights that can be flown again, those of one vehicle without thrust commands apart.

    Says why others cannot; ValueError if none can.
    """
    found: list[TrackedFlight] = []
    alone: list[FlightAlone] = []
    for one in recordings:
        with _leaving_out(only=len(recordings) == 1):
            if is_alone(one):
                alone.append(flight_alone(one))
            else:
                found.append(tracked_flight(one, vehicle))
    return found, alone


def _all_flown(
    flights: Sequence[TrackedFlight], air: FlownAir, vehicle: Vehicle, draws: int, *, only: bool = False
) -> list[ValidatedFlight]:
    """Return the flights whose law can be read; says why others cannot, ValueError if it is the only one."""
    done: list[ValidatedFlight] = []
    for one in flights:
        with _leaving_out(only=only):
            done.append(_flown(one, air, vehicle, draws))
    return done


@contextmanager
def _leaving_out(*, only: bool) -> Iterator[None]:
    """Say why a flight is refused within, and go on with the others; raise if it is the only one."""
    try:
        yield
    except ValueError as refusal:
        if only:
            raise
        _say(f"left out: {refusal}")


def _flown_alone(flight: FlightAlone, air: FlownAir, vehicle: Vehicle, draws: int) -> ComparedAlone:
    one = compared_alone(flight, vehicle, air, range(draws))
    print(_line(f"{flight.name}, height", comparison([one.vertical])))
    return one


def _flown(flight: TrackedFlight, air: FlownAir, vehicle: Vehicle, draws: int) -> ValidatedFlight:
    make = draws_in(air, flight, vehicle)
    one = validate_flight(flight, vehicle_of_room(air, vehicle), make, range(draws))
    for note in _flight_notes(one):
        _say(note)
    print(_line(flight.name, comparison(one.under if one.has_wake else one.clear)))
    return one


def _flight_notes(one: ValidatedFlight) -> list[str]:
    """Return what of a flight is not compared, or not flown again."""
    flight = one.flight
    under = flight.exposed.any(axis=0)
    few = [name for name, left in zip(flight.names, under & ~flight.scored, strict=True) if left]
    notes = [
        f"{flight.name}: {name} is not compared, as it has fewer than {FEWEST_FREE} rows in clear air"
        for name in few
    ]
    if one.law.compensates and flight.model is None:
        notes.append(
            f"{flight.name}: its downwash compensation is repeated as recorded, wherever the simulated "
            "vehicles fly: no interaction model is known that gives it"
        )
    if not under.any():
        return [f"{flight.name} has no row under another vehicle: only its clear air is compared"]
    return notes if one.has_wake else [*notes, f"{flight.name}: only clear air is compared"]


def _line(name: str, one: Comparison) -> str:
    if one.z_rms_ratio is None:
        return f"{name:32} nothing to compare"
    spectrum = "-" if one.spectrum_db is None else f"{one.spectrum_db:.1f} dB"
    correlation = "-" if one.correlation is None else f"{one.correlation:.2f}"
    return (
        f"{name:32} rms ratio {one.z_rms_ratio:.2f}, correlation {correlation}, spectrum {spectrum}, "
        f"in band {one.coverage95:.0%}, worst {one.worst_ratio:.2f}, n {one.n}"
    )


def _say(note: str) -> None:
    print(f"validate: {note}", file=sys.stderr)
