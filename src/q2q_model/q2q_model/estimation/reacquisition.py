"""Remember refused samples, so that a true jump is believed: a gate must not stay closed for ever.

A vehicle's rival is the place where its refused samples gather. A refused sample joins the rival when it
could have come from there, |r - r_last| <= jump_max + speed_max (t - t_last); else it starts a new one.
A rival that has gathered CONFIRM_SAMPLES and lasted as long as is asked is where the vehicle is.
"""

from typing import NamedTuple

import numpy as np

from q2q_model.estimation.track_rows import padded
from q2q_model.flights.outliers import Mask, OutlierThresholds
from q2q_model.signals.values import Array

CONFIRM_SAMPLES = 3
"""A jump is believed after at least as many samples, whatever their rate."""
SAME_INSTANT = 1e-9
"""Rounding of a time of flight in float64 [s]."""


class Lacking(NamedTuple):
    """Vehicles without a believable sample of their own at a tick."""

    absent: Mask
    """Seen before, without a sample now, (n,)."""
    refused: Mask
    """(n,)"""


class Reacquisition:
    """Competing tracks, at most one a vehicle."""

    def __init__(self, count: int, limits: OutlierThresholds) -> None:
        """Start without any."""
        self._limits = limits
        self._count = np.zeros(count, dtype=np.int64)
        self._first_time = np.zeros(count)
        self._last_time = np.zeros(count)
        self._first_pos = np.zeros((count, 3))
        self._last_pos = np.zeros((count, 3))

    def grow(self, extra: int) -> None:
        """Add vehicles without rivals."""
        self._count = padded(self._count, extra)
        self._first_time, self._last_time = padded(self._first_time, extra), padded(self._last_time, extra)
        self._first_pos, self._last_pos = padded(self._first_pos, extra), padded(self._last_pos, extra)

    def forget(self, vehicles: Mask) -> None:
        """Drop the rivals of vehicles whose own samples are good."""
        self._count[vehicles] = 0

    def offer(self, t: float, pos: Array, refused: Mask, patience: Array) -> Mask:
        """Take refused samples pos [m] (n, 3) at t [s]; return whose rival is now believed, (n,).

        `patience` (n,) is how long each rival must have lasted [s].
        """
        reach = self._limits.jump_max + self._limits.speed_max * (t - self._last_time)
        with np.errstate(invalid="ignore"):
            joins = refused & (self._count > 0) & (np.linalg.norm(pos - self._last_pos, axis=-1) <= reach)
        starts = refused & ~joins
        self._first_time[starts], self._first_pos[starts] = t, pos[starts]
        self._last_time[refused], self._last_pos[refused] = t, pos[refused]
        self._count[starts] = 1
        self._count[joins] += 1
        lasted = t - self._first_time >= patience - SAME_INSTANT
        return refused & lasted & (self._count >= CONFIRM_SAMPLES)

    def doubtful(self, t: float, pos: Array, tracks: tuple[Array, Array], lacking: Lacking) -> Mask:
        """Return whose sample at pos [m] (n, 3) may be another's under a wrong name, (n,).

        The other one lacks a sample of its own, and was nearer to it than the sample's own vehicle: it is
        absent, and may have come there; or its sample is refused, too: a swap of a marker that was moved.
        Swaps end before a vehicle has coasted. `tracks` are last positions [m] (n, 3) and their times
        [s] (n,).
        """
        last, when = tracks
        others = np.flatnonzero(lacking.refused | lacking.absent)  # (m,)
        away = np.linalg.norm(pos[:, None] - last[others], axis=2)  # (n, m): of i's sample to j's track
        own = np.linalg.norm(pos - last, axis=1)[:, None]
        reached = away <= self._limits.jump_max + self._limits.speed_max * (t - when[others])
        suspect = lacking.refused[others] | reached
        return np.asarray((suspect & (away < own)).any(axis=1))

    def velocity(self) -> Array:
        """Return the mean velocity of every rival [m/s], (n, 3); zero where it has one sample."""
        lasted = self._last_time - self._first_time
        moved = self._last_pos - self._first_pos
        return np.asarray(moved / np.where(lasted > 0.0, lasted, np.inf)[:, None])
