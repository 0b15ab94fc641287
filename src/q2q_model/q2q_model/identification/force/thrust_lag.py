"""Time constant of thrust, from accelerometer and command of the same flight.

    (R f_body)_z = lagged(U1; T) b_z / m + c + noise       minimised over T, with a constant c of each vehicle

Only rows without a neighbour within half a metre horizontally are used, where there is no downwash.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from q2q_model.flights.flight import Flight
from q2q_model.identification.force.recorded_force import (
    RecordedAcceleration,
    motion_of,
    recorded_acceleration,
)
from q2q_model.signals.values import Array, CommandStatus, Mask
from q2q_model.vehicle.constants import Vehicle

CLEAR = 0.5
"""Horizontal distance without observable downwash [m]."""
LONGEST = 0.4
"""Upper bound of the lag [s]."""
RESOLUTION = 1e-3
"""Tolerance of the search [s]: a tenth of a tick."""
FEWEST = 200
"""Fewest rows of a vehicle: 2 s at 100 Hz."""


@dataclass(frozen=True, slots=True)
class _ClearAir:
    """Sensor records of a flight and each vehicle's rows in clear air."""

    found: RecordedAcceleration
    clear: Mask
    """(T, n)"""


def thrust_lag(flights: Sequence[Flight], vehicle: Vehicle) -> float | None:
    """Return the lag T [s] that fits the flights best.

    None if no flight has accelerometer and command, or the bound fits best for lack of excitation.
    """
    flown = [one for flight in flights if (one := _clear_air(flight, vehicle)) is not None]
    if not any((one.clear.sum(axis=0) >= FEWEST).any() for one in flown):
        return None

    def spread(lag: float) -> float:
        return float(np.mean(np.concatenate([part for one in flown for part in _pushes(one, lag)]) ** 2))

    found = minimize_scalar(spread, bounds=(0.0, LONGEST), method="bounded", options={"xatol": RESOLUTION})
    return float(found.x) if found.x < LONGEST - 2.0 * RESOLUTION else None


def _clear_air(flight: Flight, vehicle: Vehicle) -> _ClearAir | None:
    found = recorded_acceleration(flight, vehicle)
    if found is None:
        return None
    pos = motion_of(flight).pos
    rel = np.hypot(*(pos[:, None, :, :2] - pos[:, :, None, :2]).transpose(3, 0, 1, 2))  # (T, n, n)
    rel[:, np.arange(pos.shape[1]), np.arange(pos.shape[1])] = np.inf
    saturated = flight.command_status == CommandStatus.SATURATED
    return _ClearAir(found, np.asarray(found.whole & ~saturated & (rel > CLEAR).all(axis=2)))


def _pushes(one: _ClearAir, lag: float) -> list[Array]:
    push = one.found.push(lag)
    rows = [push[one.clear[:, i], i] for i in range(push.shape[1])]
    return [part - np.median(part) for part in rows if part.size >= FEWEST]
