"""Flights of bags and tables, each given once and under a name of its own.

A flight is given twice if it holds the motion of another (flights.duplicates.same_flight), under any names.
"""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from q2q_model.bag import BagError
from q2q_model.flights.duplicates.same_flight import flight_digest, is_same_flight
from q2q_model.flights.tables.table_file import TABLES
from q2q_model.recordings.flight_recording import Recording


def reject_duplicates(paths: Sequence[Path]) -> None:
    """Raise BagError if a path is given twice."""
    found = [path.resolve() for path in paths]
    duplicates = sorted({str(path) for path in found if found.count(path) > 1})
    if duplicates:
        raise BagError(f"{', '.join(duplicates)} is given twice; give each flight once")


def distinct_flights(paths: Sequence[Path], recordings: Sequence[Recording]) -> list[Recording]:
    """Return the flights read from paths, named by parent folders too where names collide.

    Raises:
        BagError: a flight is a copy of another, or of a part of it: held out, it would be in the fit.
    """
    _reject_copies(paths, recordings)
    named = list(recordings)
    for k, one in enumerate(recordings):
        alike = [j for j, other in enumerate(recordings) if j != k and other.flight.name == one.flight.name]
        if alike:
            name = _distinct_end(paths[k], [paths[j] for j in alike])
            named[k] = replace(one, flight=replace(one.flight, name=name))
    return named


def _distinct_end(path: Path, others: Sequence[Path]) -> str:
    """Return the shortest end of a path, in whole parts, that none of other paths has.

    The suffix of a table is no part of it, unless two files differ in that only: then the path is whole.
    """
    own, theirs = _parts(path), [_parts(other) for other in others]
    sizes = range(1, len(own) + 1)
    size = next((n for n in sizes if all(other[-n:] != own[-n:] for other in theirs)), 0)
    return "/".join(own[-size:]) if size else str(path.resolve())


def _parts(path: Path) -> tuple[str, ...]:
    whole = path.resolve()
    return (whole.with_suffix("") if whole.suffix in TABLES else whole).parts


def _reject_copies(paths: Sequence[Path], recordings: Sequence[Recording]) -> None:
    digests = [flight_digest(one.flight) for one in recordings]
    for k, own in enumerate(digests):
        for j, earlier in enumerate(digests[:k]):
            if is_same_flight(own, earlier):
                raise BagError(
                    f"{paths[j]} and {paths[k]} contain the same flight or parts of it; give it once"
                )
