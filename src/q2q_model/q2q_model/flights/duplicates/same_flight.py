"""Whether a flight is among those that a model or an air was fitted to, by its content or by its name."""

from collections.abc import Collection, Iterable, Sequence
from hashlib import sha256

import numpy as np

from q2q_model.flights.duplicates.height_records import (
    height_records,
    heights_as_text,
    heights_from_text,
    hold_same_heights,
)
from q2q_model.flights.duplicates.motion_windows import as_text, from_text, hold_same_motion, motion_windows
from q2q_model.flights.flight import Flight

COPY_IN_FIT = "this flight is in the fit: not held out"
IN_FIT = "a flight of this name is in the fit: if it is this one, it is not held out"
"""Remark: a name alone may be a stranger's (`bag`), and so may one beside other contents."""


def flight_digest(flight: Flight) -> str:
    """Return "SHA-256:windows:heights" of a flight, whatever its name is.

    The SHA-256 is that of vehicles, stamps and recorded positions, the windows are those of motion_windows,
    the heights those of height_records. A simulated flight, whose true positions are known, has neither:
    flights of one seed share their noise. Flights in older files of models and airs lack heights, or both.
    """
    pos = flight.mocap_pos if np.isfinite(flight.mocap_pos).any() else flight.pos
    found = sha256("\0".join(flight.names).encode())
    for values in (flight.t, np.where(np.isnan(pos), np.nan, pos)):
        found.update((values + 0.0).astype("<f8").tobytes())
    simulated = bool(np.isfinite(flight.true_pos).any())
    windows = () if simulated else motion_windows(pos)
    heights = () if simulated else height_records(flight.t, pos)
    return f"{found.hexdigest()}:{as_text(windows)}:{heights_as_text(heights)}"


def is_same_flight(one: str, other: str) -> bool:
    """Return whether two digests are those of one flight, or of a flight and a part of it.

    A recorded flight may be cut, moved in time or place, saved in single precision, and its vehicles may be
    renamed. One of 10 s or more may also have another rate, be turned about z or mirrored, and have noise.
    """
    whole, windows, heights = [*one.split(":"), "", ""][:3]
    other_whole, other_windows, other_heights = [*other.split(":"), "", ""][:3]
    return (
        whole == other_whole
        or hold_same_motion(from_text(windows), from_text(other_windows))
        or hold_same_heights(heights_from_text(heights), heights_from_text(other_heights))
    )


def fit_remarks(flights: Iterable[Flight], names: Sequence[str], digests: Collection[str]) -> dict[str, str]:
    """Return by their names a remark on the flights that are, or may be, among fitted ones.

    Args:
        flights: flights that are not to be in the fit.
        names: names of the fitted flights.
        digests: their digests; none in files of models and airs that are older than these.
    """
    flights = list(flights)
    named = {one.name: IN_FIT for one in flights if is_among(one.name, names)}
    return named | {one.name: COPY_IN_FIT for one in flights if digests and _is_any(one, digests)}


def _is_any(flight: Flight, digests: Collection[str]) -> bool:
    own = flight_digest(flight)
    return any(is_same_flight(own, one) for one in digests)


def is_among(name: str, fitted: Iterable[str]) -> bool:
    """Return whether a flight is among others; the folders before a name may be missing in either."""
    return any(f"/{name}".endswith(f"/{one}") or f"/{one}".endswith(f"/{name}") for one in fitted)
