"""Loss of a flight: how far a vehicle is off its setpoint, by true positions.

    distance: d(t) = min(|r_set - r|, LOST)
    height:   d(t) = min(max(z_set - z, 0), LOST)

A vehicle that is LOST away has left its path (policy `setpoint_error`): how far it goes then says nothing
more.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from q2q_model.flights.flight import Flight
from q2q_model.signals.values import Array
from q2q_sim.monitors.policies import Limits

LossKind = Literal["distance", "height"]
LOST = Limits().setpoint_error_max
"""[m]"""
ACCIDENT = Limits().back
"""Minimum loss of an accident [m]."""
ORDINARY = 0.5 * ACCIDENT
"""Largest loss of an ordinary flight, whose vehicles stay on their paths [m]."""


@dataclass(frozen=True, slots=True)
class Loss:
    """Largest loss of a flight."""

    kind: LossKind
    vehicle: str
    row: int
    """Row of the vehicle in the flight."""
    t: float
    """When it is first reached [s]."""
    size: float
    """[m]; LOST or less."""

    @property
    def is_ordinary(self) -> bool:
        """Return whether every vehicle stays on its path."""
        return self.size <= ORDINARY


def largest_loss(flight: Flight, kind: LossKind = "distance") -> Loss:
    """Return the largest loss of a simulated flight, the first one of equals."""
    lost = loss_over_time(flight, kind)
    tick, row = np.unravel_index(int(lost.argmax()), lost.shape)
    return Loss(
        kind=kind,
        vehicle=flight.names[row],
        row=int(row),
        t=float(flight.t[tick]),
        size=float(lost[tick, row]),
    )


def loss_over_time(flight: Flight, kind: LossKind) -> Array:
    """Return d [m], (T, n); LOST where a position is not a number."""
    off = flight.safe_pos - flight.true_pos
    lost = np.linalg.norm(off, axis=-1) if kind == "distance" else np.maximum(off[..., 2], 0.0)
    return np.asarray(np.fmin(lost, LOST))
