"""Values of a recorded flight that no small vehicle can have, as of a damaged message: they are left out.

One of 1e200 is finite and a gap to nobody: squared, it makes a fit NaN.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from q2q_model.counted import counted
from q2q_model.flights.flight import FIELD_WIDTHS, Flight
from q2q_model.flights.flight_log import FlightLog
from q2q_model.signals.values import Array, Mask, Names

LARGEST = 1e4
"""Largest value of any quantity in SI units: 10 km, 10 kN, 10^4 m/s^2, 10^4 rad/s."""
FORCES = ("faz_est", "thrust_est", "fa_ff")
"""Columns of a log that are read as forces [N]; others are in any unit."""


def possible_flight(flight: Flight) -> tuple[Flight, list[str]]:
    """Return the flight with NaN for impossible values, itself if there are none, and remarks on them."""
    found = {name: _impossible(getattr(flight, name)) for name in FIELD_WIDTHS}
    made = {name: getattr(flight, name).copy() for name, wrong in found.items() if wrong.any()}
    remarks: list[str] = []
    for name, values in made.items():
        remarks += _remarks(name, values, found[name], (flight.t, flight.names))
        values[found[name]] = np.nan
    return (replace(flight, **made) if made else flight), remarks


def possible_log(log: FlightLog) -> tuple[FlightLog, list[str]]:
    """Return the log with NaN for impossible forces, itself if there are none, and remarks on them."""
    forces = np.isin(log.columns, FORCES)
    wrong = (np.abs(log.values) > LARGEST) & forces
    remarks = [
        remark
        for k in np.flatnonzero(wrong.any(axis=(0, 1))).tolist()
        for remark in _remarks(log.columns[k], log.values[..., k], wrong[..., k], (log.t, log.names))
    ]
    return (replace(log, values=np.where(wrong, np.nan, log.values)) if remarks else log), remarks


def _impossible(values: Array) -> Mask:
    """Return where a value, or one of a vector, is too large, (T, n)."""
    beyond = np.abs(values) > LARGEST  # NaN is not
    return np.asarray(beyond if values.ndim == 2 else beyond.any(axis=-1))


def _remarks(what: str, values: Array, wrong: Mask, axes: tuple[Array, Names]) -> Iterator[str]:
    """Yield a remark for each vehicle with impossible values (T, n) or (T, n, c) of a quantity."""
    t, names = axes
    for i in np.flatnonzero(wrong.any(axis=0)).tolist():
        row, count = int(np.argmax(wrong[:, i])), int(wrong[:, i].sum())
        value = float(np.nanmax(np.abs(values[row, i])))
        yield (
            f"{what} of {names[i]} is {value:.3g} at {t[row]:.3f} s, maximum {LARGEST:g} (SI units): "
            f"{counted(count, 'such value')} left out"
        )
