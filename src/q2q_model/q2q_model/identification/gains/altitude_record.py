"""Altitude record of a flight, the data of section 3: positions, altitude reference and command.

| symbol | name | meaning [unit] |
|---|---|---|
| r | pos | position [m], world, (T, n, 3) |
| z_ref z_ref' z_ref'' | ref | altitude reference and its derivatives [m], [m/s], [m/s^2], (T, n, 3) |
| U1 b_z / m - g | commanded_acc | commanded vertical acceleration [m/s^2], (T, n) |

A record has no hole (flown_pieces).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from q2q_model.signals.values import Array, Mask, Names


@dataclass(frozen=True, slots=True)
class AltitudeRecord:
    """Altitudes of one flight on an even grid, without gaps."""

    name: str
    names: Names
    dt: float
    t: Array
    """[s], (T,)."""
    pos: Array
    vel: Array
    """Velocity [m/s], world, (T, n, 3)."""
    axis: Array
    """Body z, world, (T, n, 3)."""
    ref: Array
    commanded_acc: Array
    """Commanded vertical acceleration in flight [m/s^2], (T, n); NaN where command, position or reference was
    not recorded, and on the ground."""
    feed_forward: Array
    """Downwash compensated by the controller [m/s^2], along z, (T, n); NaN where not recorded."""
    added_acc: Array
    """Acceleration by feed-forward and a constant, added to (13), along z [m/s^2], (T, n); 0 if unknown."""
    outliers: int
    """Number of outliers among the motion capture samples."""
    samples: int
    rates_fitted: bool = False
    """Whether z_ref' and z_ref'' were not recorded: what of them the controller had is not known."""
    acc_differentiated: bool = False
    """Whether z_ref'' is the differences of z_ref': at a limit of it, the controller was given another."""

    @property
    def deviation(self) -> Array:
        """Return z - z_ref [m], (T, n)."""
        return self.pos[..., 2] - self.ref[..., 0]

    @property
    def start(self) -> Array:
        """Return z - z_ref [m] and its rate [m/s] at the first tick, (2, n)."""
        return np.stack([self.deviation[0], self.vel[0, :, 2] - self.ref[0, :, 1]])

    @property
    def jerk(self) -> Array:
        """Return z_ref''' [m/s^3], (T, n)."""
        return np.asarray(np.gradient(self.ref[..., 2], self.dt, axis=0))


def flight_numbers(records: Sequence[AltitudeRecord]) -> list[int]:
    """Return for each record the number of its flight: those of one name are pieces of one flight."""
    names = list(dict.fromkeys(record.name for record in records))
    return [names.index(record.name) for record in records]


def in_clear_air(record: AltitudeRecord, distance: float) -> Mask:
    """Return the ticks at which no other vehicle is within a horizontal distance [m], (T, n)."""
    clear = np.empty(record.pos.shape[:2], dtype=np.bool_)
    for i in range(len(record.names)):
        rel = np.delete(record.pos, i, axis=1) - record.pos[:, i : i + 1]  # (T, n - 1, 3)
        clear[:, i] = (np.hypot(rel[..., 0], rel[..., 1]) > distance).all(axis=1)
    return clear


def decimate(record: AltitudeRecord, every: int) -> AltitudeRecord:
    """Return every `every`-th tick of a record."""
    rows = slice(None, None, every)
    return replace(
        record,
        dt=every * record.dt,
        t=record.t[rows],
        pos=record.pos[rows],
        vel=record.vel[rows],
        axis=record.axis[rows],
        ref=record.ref[rows],
        commanded_acc=record.commanded_acc[rows],
        feed_forward=record.feed_forward[rows],
        added_acc=record.added_acc[rows],
    )
