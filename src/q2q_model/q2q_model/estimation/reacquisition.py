"""Reacquisition after a true jump: rejected samples that stay together are accepted.

Each track has at most one candidate, the place where its rejected samples gather. A rejected sample joins
the candidate if the vehicle could have moved there, |r - r_last| <= jump_max + speed_max (t - t_last), and
t - t_last <= GAP_S; otherwise it starts a new candidate. A candidate with CONFIRM_SAMPLES samples that has
lasted for the required time becomes the track, unless more than half of that is one gap: those before and
after it may have met by chance.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from q2q_model.flights.outliers import Mask, OutlierThresholds
from q2q_model.signals.values import Array

Table = NDArray[np.void]

CONFIRM_SAMPLES = 3
"""Least number of samples of an accepted jump, whatever their rate."""
GAP_S = 0.15
"""Longest time between samples that stay together [s]: motion capture at 10 Hz still works."""
FLIES_ON_S = 1.0
"""Time for which an absent vehicle goes on at its last velocity [s]: then it has braked."""
STRAYS = 1.1
"""Speed at which an absent vehicle may stray from there [m/s]: that of a landing without measurements."""
SAME_INSTANT = 1e-9
"""Rounding of a time in float64 [s]."""
CANDIDATE = np.dtype(
    [
        ("samples", np.int64),  # 0 is no candidate
        ("first_time", np.float64),
        ("last_time", np.float64),
        ("first_pos", np.float64, 3),
        ("last_pos", np.float64, 3),
        ("gap", np.float64),  # longest time between two samples
        ("ambiguous", np.bool_),
    ]
)
"""Columns of a candidate [s, m]."""


class Unmatched(NamedTuple):
    """Tracks without an accepted sample at a tick."""

    absent: Mask
    """Seen before, without a sample now, or with one that is another vehicle's, (n,)."""
    rejected: Mask
    """With a rejected sample, (n,)."""


class LastSample(NamedTuple):
    """State of each track at its last accepted sample."""

    pos: Array
    """[m], (n, 3)."""
    vel: Array
    """[m/s], (n, 3)."""
    time: Array
    """[s], (n,)."""


class Reacquisition:
    """Candidates for a restart, at most one per track."""

    def __init__(self, count: int, limits: OutlierThresholds) -> None:
        """Start `count` tracks without candidates."""
        self._limits = limits
        self._candidates = np.zeros(count, CANDIDATE)

    @property
    def candidates(self) -> Table:
        """Return the candidates, CANDIDATE (n,), which stay in this table until they grow."""
        return self._candidates

    def grow(self, extra: int) -> None:
        """Add tracks without candidates."""
        self._candidates = np.concatenate([self._candidates, np.zeros(extra, CANDIDATE)])

    def set_back(self, by: float) -> None:
        """Set the times of all candidates back by `by` [s]."""
        self._candidates["first_time"] -= by
        self._candidates["last_time"] -= by

    def forget(self, tracks: Mask) -> None:
        """Drop the candidates of tracks with an accepted sample."""
        self._candidates["samples"][tracks] = 0
        self._candidates["ambiguous"][tracks] = False

    def offer(self, t: float, pos: Array, rejected: Mask, patience: Array) -> Mask:
        """Add rejected samples pos [m] (n, 3) at t [s]; return which candidates are now accepted, (n,).

        `patience` (n,) is how long each candidate must have lasted [s].
        """
        one, joins = self._candidates, rejected & self._near(t, pos)
        starts = rejected & ~joins
        one["first_time"][starts], one["first_pos"][starts] = t, pos[starts]
        one["gap"][starts] = 0.0
        one["gap"][joins] = np.maximum(one["gap"], t - one["last_time"])[joins]
        one["last_time"][rejected], one["last_pos"][rejected] = t, pos[rejected]
        one["samples"][starts] = 1
        one["samples"][joins] += 1
        lasted = t - one["first_time"] >= patience - SAME_INSTANT
        steady = one["gap"] <= 0.5 * (t - one["first_time"]) + SAME_INSTANT
        return np.asarray(rejected & lasted & steady & (one["samples"] >= CONFIRM_SAMPLES))

    def ambiguous(self, t: float, pos: Array, last: LastSample, unmatched: Unmatched) -> Mask:
        """Note and return which samples at pos [m] (n, 3) may be of another vehicle with a wrong name, (n,).

        The other vehicle has no accepted sample, and the sample is nearer to it than to the vehicle of its
        name: to where each was last, or would be by its last velocity, and may have strayed from there. How
        far it could have moved there says nothing: a marker may have moved, too. Swaps end before a vehicle
        has coasted. A candidate that was ambiguous remains so while any other vehicle is without an accepted
        sample.
        """
        open_rows = unmatched.rejected | unmatched.absent
        noted = self._candidates["ambiguous"]
        noted &= open_rows.sum() > open_rows  # another one
        noted &= self._near(t, pos) | ~unmatched.rejected
        mine, others = np.flatnonzero(unmatched.rejected), np.flatnonzero(open_rows)  # (r,), (m,)
        since = t - last.time
        flown = last.pos + np.minimum(since, FLIES_ON_S)[:, None] * last.vel
        away = np.minimum(*(_distances(pos[mine], place[others]) for place in (last.pos, flown)))
        away -= STRAYS * since[others]
        own = away[np.arange(mine.size), np.searchsorted(others, mine)]
        noted[mine] |= (away < own[:, None]).any(axis=1)
        return noted.copy()

    def _near(self, t: float, pos: Array) -> Mask:
        """Return which samples at pos [m] (n, 3) join the candidates of their rows, (n,)."""
        one = self._candidates
        since = t - one["last_time"]
        reach = self._limits.jump_max + self._limits.speed_max * since
        near = np.linalg.norm(pos - one["last_pos"], axis=-1) <= reach
        return np.asarray((one["samples"] > 0) & (since <= GAP_S + SAME_INSTANT) & near)

    def velocity(self) -> Array:
        """Return the mean velocity of every candidate [m/s], (n, 3); zero for a single sample."""
        one = self._candidates
        lasted = one["last_time"] - one["first_time"]
        moved = one["last_pos"] - one["first_pos"]
        return np.asarray(moved / np.where(lasted > 0.0, lasted, np.inf)[:, None])


def _distances(one: Array, other: Array) -> Array:
    """Return the distances of places (r, 3) to others (m, 3), (r, m) [m]."""
    return np.asarray(np.linalg.norm(one[:, None] - other, axis=2))
