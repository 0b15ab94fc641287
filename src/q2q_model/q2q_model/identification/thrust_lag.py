"""Find how far thrust lags behind its command, with accelerometer and command of the same flight.

    (R f_body)_z = lagged(U1; T) b_z / m + c + noise       minimised over T, c taken off for each vehicle

Only rows without a neighbour within half a metre sideways count: there the rotors alone push.
"""

from collections.abc import Sequence

import numpy as np
from scipy.optimize import minimize_scalar

from q2q_model.flights import Flight
from q2q_model.identification.recorded_push import push_of_sensors
from q2q_model.signals import Array
from q2q_model.vehicle import Vehicle

CLEAR = 0.5
"""Horizontal distance beyond which no draft has been seen [m]."""
LONGEST = 0.4
"""Largest lag looked for [s]."""
FEWEST = 200
"""Rows of one vehicle: 2 s at 100 Hz."""


def thrust_lag(flights: Sequence[Flight], vehicle: Vehicle) -> float | None:
    """Return the lag T [s] that explains the flights best; None where none has accelerometer and command."""

    def spread(lag: float) -> float:
        parts = [part for flight in flights for part in _clear_pushes(flight, vehicle, lag)]
        return float(np.mean(np.concatenate(parts) ** 2)) if parts else float("nan")

    if np.isnan(spread(0.0)):
        return None
    found = minimize_scalar(spread, bounds=(0.0, LONGEST), method="bounded", options={"xatol": 1e-3})
    return float(found.x)


def _clear_pushes(flight: Flight, vehicle: Vehicle, lag: float) -> list[Array]:
    record = push_of_sensors(flight, vehicle, lag)
    if record is None:
        return []
    pos = record.motion.pos
    rel = np.hypot(*(pos[:, None, :, :2] - pos[:, :, None, :2]).transpose(3, 0, 1, 2))  # (T, n, n)
    rel[:, np.arange(pos.shape[1]), np.arange(pos.shape[1])] = np.inf
    clear = record.whole & ~record.saturated & (rel > CLEAR).all(axis=2)
    rows = [record.push[clear[:, i], i] for i in range(pos.shape[1])]
    return [part - np.median(part) for part in rows if part.size >= FEWEST]
