"""Rows of recorded flights with one or two vehicles above another."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from q2q_model.identification.push.push_samples import GAPS, PushSamples
from q2q_model.signals.values import Array, Mask, Rows
from q2q_sim.air.learning.jet.jet_coordinates import JetPlace, Travel, jet_place
from q2q_sim.air.learning.records.air_record import AirRecord
from q2q_sim.air.learning.statistics.block_bootstrap import BlockOfRows, Row, block_of_rows

NEAR = 0.35
"""Horizontal distance within which a vehicle above is a source [m]: the table's reach and 0.05 m of drift."""
CLOSEST, HIGHEST = 0.05, GAPS[1]
"""Gaps of a source [m]: nothing flies closer; the scoring rule's bound."""


@dataclass(frozen=True, slots=True)
class WakeRows:
    """Rows of one vehicle under given others."""

    record: AirRecord
    one: PushSamples
    sources: tuple[int, ...]
    """Vehicles above, the nearest first."""
    rows: Rows

    @property
    def y(self) -> Array:
        """Return the measured push [m/s^2], (k,)."""
        return self.one.y[self.rows]

    @property
    def exposed(self) -> Mask:
        """Return which rows the scoring rule calls exposed, (k,)."""
        return self.one.exposed[self.rows]


def rows_under_one(records: Sequence[AirRecord]) -> list[WakeRows]:
    """Return the rows with exactly one source."""
    found = []
    for record, one, above in _with_sources(records):
        lone = one.usable & (above.sum(axis=1) == 1)
        parts = [
            WakeRows(record, one, (j,), np.flatnonzero(lone & column)) for j, column in enumerate(above.T)
        ]
        found += [part for part in parts if part.rows.size]
    return found


def rows_under_two(records: Sequence[AirRecord]) -> list[WakeRows]:
    """Return the exposed rows with exactly two sources, by the order of their heights."""
    found = []
    for record, one, above in _with_sources(records):
        both = one.exposed & (above.sum(axis=1) == 2)
        height = record.motion.pos[..., 2]
        for j in range(record.vehicles):
            for k in range(record.vehicles):
                rows = np.flatnonzero(both & above[:, j] & above[:, k] & (height[:, j] < height[:, k]))
                if rows.size:
                    found.append(WakeRows(record, one, (j, k), rows))
    return found


def _with_sources(records: Sequence[AirRecord]) -> list[tuple[AirRecord, PushSamples, Mask]]:
    """Return each vehicle's samples and which others are sources above it, (T, n)."""
    found = []
    for record in records:
        for one in record.samples:
            rel = record.motion.pos - record.motion.pos[:, one.vehicle, None]
            across, gap = np.hypot(rel[..., 0], rel[..., 1]), rel[..., 2]
            above = (across < NEAR) & (gap > CLOSEST) & (gap < HIGHEST)
            found.append((record, one, np.asarray(above)))
    return found


def jet_places(parts: Sequence[WakeRows], travel: Travel, source: int = 0) -> JetPlace:
    """Return the places in the jets of each part's `source`, of all parts in order."""
    found = [
        jet_place(part.record, (part.one.vehicle, part.sources[source]), part.rows, travel) for part in parts
    ]
    return JetPlace(*(np.concatenate(column) for column in zip(*map(_columns, found), strict=True)))


def _columns(place: JetPlace) -> tuple[Array, Array, Array, Array]:
    return place.gap, place.radius, place.toward, place.thrust_ratio


def row_blocks(parts: Sequence[WakeRows]) -> BlockOfRows:
    """Return the block of every row of all parts in order."""
    return block_of_rows([Row(part.record.name, part.record.motion.t[part.rows]) for part in parts])
