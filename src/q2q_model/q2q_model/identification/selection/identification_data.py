"""Data of one flight for identification, and the roles of its vehicles."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from q2q_model.identification.gains.altitude_record import AltitudeRecord
from q2q_model.identification.push.push_samples import GAPS, UNDER, PushSamples
from q2q_model.signals.values import Array, Mask

NEAR = 0.5
"""Horizontal distance within which a vehicle counts as above or below another [m]."""


@dataclass(frozen=True, slots=True)
class IdentificationData:
    """Data of one flight: altitudes, and pushes if sensors and commands were recorded."""

    records: tuple[AltitudeRecord, ...]
    """One, or one from each hole of the flight to the next."""
    pushes: tuple[PushSamples, ...]

    @property
    def name(self) -> str:
        """Return the flight's name."""
        return self.records[0].name


def every_record(flights: Sequence[IdentificationData]) -> list[AltitudeRecord]:
    """Return the records of all flights."""
    return [record for flight in flights for record in flight.records]


def measures_downwash(flights: Sequence[IdentificationData]) -> bool:
    """Return whether the push on any vehicle under another was measured."""
    return any(one.exposed.any() for flight in flights for one in flight.pushes)


def under_others(record: AltitudeRecord) -> Mask:
    """Return which vehicles fly under another, by the scoring rule, (n,)."""
    found = np.zeros(len(record.names), dtype=np.bool_)
    for i in range(found.size):
        rel = record.pos - record.pos[:, i : i + 1]  # (T, n, 3)
        gap = rel[..., 2]
        found[i] = ((np.hypot(rel[..., 0], rel[..., 1]) < UNDER) & (gap > GAPS[0]) & (gap < GAPS[1])).any()
    return found


def has_exposure(record: AltitudeRecord) -> bool:
    """Return whether any vehicle flies under another, by the scoring rule."""
    return bool((_gaps(record) < GAPS[1]).any())


def largest_gap(records: Sequence[AltitudeRecord]) -> float:
    """Return the largest height difference of a vehicle under another [m]; 0 if none flies so.

    Gaps beyond those of the scoring rule count: they are flown.
    """
    return max((float(_gaps(record).max(initial=0.0)) for record in records), default=0.0)


def _gaps(record: AltitudeRecord) -> Array:
    """Return the height differences at which a vehicle is under another [m]."""
    found = [np.empty(0)]
    for i in range(len(record.names)):
        rel = record.pos[:, i + 1 :] - record.pos[:, i : i + 1]  # (T, n - 1 - i, 3)
        gap = np.abs(rel[..., 2])
        found.append(gap[(np.hypot(rel[..., 0], rel[..., 1]) < UNDER) & (gap > GAPS[0])])
    return np.concatenate(found)


def is_lower(record: AltitudeRecord) -> list[bool]:
    """Return for each vehicle whether it is on average below its near neighbours, (n,)."""
    below = []
    for i in range(len(record.names)):
        others = [j for j in range(len(record.names)) if j != i]
        rel = record.pos[:, others] - record.pos[:, i : i + 1]
        near = np.hypot(rel[..., 0], rel[..., 1]) < NEAR
        above = rel[..., 2][near] if near.any() else rel[..., 2]
        below.append(bool(above.size) and bool(np.mean(above) > 0.0))
    return below
