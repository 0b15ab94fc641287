"""Notes on logs that lack a column of a vehicle, or whose thrust does not show the mass of their force."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from q2q_model.counted import counted
from q2q_model.identification.push.log_mass import HEAVIEST, LIGHTEST, can_weigh, shown_masses
from q2q_model.identification.push.recorded_push import has_values, push_log, recorded_acceleration
from q2q_model.recordings.flight_recording import Recording
from q2q_model.vehicle.constants import Vehicle

RATIO = "(faz_est + thrust_est) / (a_z + g)"


class _Shown(NamedTuple):
    """Mass that a vehicle's rows of a log show."""

    flight: str
    vehicle: str
    mass: float
    """[kg], NaN if they show none."""


def log_column_notes(recordings: Sequence[Recording], vehicle: Vehicle) -> list[str]:
    """Return notes on columns that vehicles lack in logs, and on masses that thrust_est does not show."""
    return _missing_columns(recordings, vehicle) + _masses(recordings, vehicle)


def _missing_columns(recordings: Sequence[Recording], vehicle: Vehicle) -> list[str]:
    flights: dict[str, list[str]] = {}
    for one in recordings:
        for lack in _lacks(one, vehicle):
            flights.setdefault(lack, []).append(one.flight.name)
    return [f"{', '.join(names)}: {lack}" for lack, names in flights.items()]


def _lacks(one: Recording, vehicle: Vehicle) -> list[str]:
    """Return what some vehicles lack in the log of a flight, and what is used instead."""
    log = push_log(one)
    if log is None:
        return []
    forced, bounded = has_values(log, "faz_est"), has_values(log, "gap")
    found = recorded_acceleration(one.flight, vehicle)
    felt = found.known.any(axis=0) if found else np.zeros_like(forced)
    lacks = {
        "faz_est": (
            ~forced & felt,
            f"push from imu and command, with a thrust lag of {vehicle.thrust_lag:g} s",
        ),
        "faz_est, or imu and command,": (~forced & ~felt, "no push is known on it, or near it"),
        "gap": (forced & ~bounded, "all its rows count as measured"),
    }
    return [
        f"no {column} of {', '.join(np.array(log.names)[of])} in the log: {then}"
        for column, (of, then) in lacks.items()
        if of.any()
    ]


def _masses(recordings: Sequence[Recording], vehicle: Vehicle) -> list[str]:
    shown = [found for one in recordings for found in _shown(one)]
    unknown = [one for one in shown if np.isnan(one.mass)]
    wrong = [one for one in shown if not np.isnan(one.mass) and not can_weigh(vehicle, np.array(one.mass))]
    assumed = f"faz_est is divided by the {1e3 * vehicle.mass:g} g of {vehicle.name}"
    notes = []
    if unknown:
        notes.append(
            f"{RATIO} of {_whose(unknown)} is unknown: {assumed}; "
            "record thrust_est, accelerometer and attitude"
        )
    if wrong:
        notes.append(
            f"{RATIO} of {_whose(wrong)} is {float(np.median([one.mass for one in wrong])):.3g} kg, expected "
            f"{LIGHTEST:g} to {HEAVIEST:g} times the mass of {vehicle.name}: {assumed}; check that "
            "both are in newtons and az is in m/s^2 without gravity"
        )
    return notes


def _shown(one: Recording) -> list[_Shown]:
    """Return the mass that each vehicle with a force in a log shows; none without a column of thrust."""
    log = push_log(one)
    if log is None or "thrust_est" not in log.columns:
        return []
    rows = zip(log.names, has_values(log, "faz_est"), shown_masses(log, one.flight).tolist(), strict=True)
    return [_Shown(one.flight.name, name, mass) for name, forced, mass in rows if forced]


def _whose(shown: Sequence[_Shown]) -> str:
    """Return the vehicles, and the number of flights."""
    vehicles = dict.fromkeys(one.vehicle for one in shown)
    return f"{', '.join(vehicles)} in {counted(len({one.flight for one in shown}), 'flight')}"
