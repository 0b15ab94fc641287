"""Rejected samples that may be of another vehicle with a wrong name.

A sample is suspected if another vehicle has no accepted one, either, and

    it is nearer to that one than to the vehicle of its name: to where each was last, or would be by its last
    velocity, less how far it may have strayed from there;
    or both have rejected samples, which are nearer to the vehicles with names exchanged, by their sum;
    or it is nearer to that one without straying, and goes on with rejected samples of that one's name;
    or the samples gathered before it move as that one did, rather than as the vehicle of its name.

How far a vehicle could have moved says nothing: a marker may have moved, too. But a marker that moved goes on
moving with its vehicle.
"""

from typing import NamedTuple

import numpy as np

from q2q_model.estimation.association.jump_candidates import Table, joins_candidates, mean_velocity
from q2q_model.estimation.association.outlier_thresholds import OutlierThresholds
from q2q_model.signals.values import Array, Mask, Rows

FLIES_ON_S = 1.0
"""Time for which an absent vehicle goes on at its last velocity [s]: then it has braked."""
STRAYS = 1.1
"""Speed at which an absent vehicle may stray from there [m/s]: that of a landing without measurements."""
OTHER_MOTION = 0.2
"""Difference of velocities by which two vehicles are distinguished [m/s]: three times the error of a velocity
from MOVING_SAMPLES with 1 mm of noise at 100 Hz."""
MOVING_SAMPLES = 3
"""Minimum number of samples that show how a candidate moves."""


class LastSample(NamedTuple):
    """State of each track at its last accepted sample."""

    pos: Array
    """[m], (n, 3)."""
    vel: Array
    """[m/s], (n, 3)."""
    time: Array
    """[s], (n,)."""
    coasting: Mask
    """Not lost since, so that the velocity still says something, (n,)."""


class Unmatched(NamedTuple):
    """Tracks without an accepted sample at a tick."""

    absent: Mask
    """Seen before, without a sample now, or with one that is another vehicle's, (n,)."""
    rejected: Mask
    """With a rejected sample, (n,)."""

    @property
    def either(self) -> Mask:
        """Return the tracks without an accepted sample, (n,)."""
        return np.asarray(self.absent | self.rejected)


class SwapEvidence(NamedTuple):
    """Samples of a tick, and tracks and candidates before it, from which a swap is recognised."""

    t: float
    """[s]"""
    pos: Array
    """Samples [m], (n, 3)."""
    last: LastSample
    candidates: Table
    """CANDIDATE, (n,)."""
    limits: OutlierThresholds


def suspected_swaps(found: SwapEvidence, unmatched: Unmatched) -> Mask:
    """Return which rejected samples may be of another vehicle with a wrong name, (n,)."""
    mine, others = np.flatnonzero(unmatched.rejected), np.flatnonzero(unmatched.either)  # (r,), (m,)
    own = np.arange(mine.size), np.searchsorted(others, mine)
    straight, strayed = _away(found, mine, others)
    suspected = _less(strayed, own) | (_less(straight, own) & _goes_on(found, mine, others, own))
    suspected |= _moves_along(found, mine, others, own)
    exchanged = _nearer_exchanged(straight[:, own[1]]).any(axis=1)
    swapped = np.zeros(len(found.pos), dtype=np.bool_)
    swapped[mine] = suspected.any(axis=1) | exchanged
    return swapped


def _away(found: SwapEvidence, mine: Rows, others: Rows) -> tuple[Array, Array]:
    """Return how far samples (r,) are from vehicles (m,) [m], and the same less their straying, (r, m)."""
    last, since = found.last, found.t - found.last.time
    flown = last.pos + np.minimum(since, FLIES_ON_S)[:, None] * last.vel
    away = np.minimum(*(_distances(found.pos[mine], place[others]) for place in (last.pos, flown)))
    return away, away - STRAYS * since[others]


def _nearer_exchanged(away: Array) -> Mask:
    """Return which two samples are nearer to each other's vehicles, (r, r), by their distances, (r, r)."""
    kept = np.diag(away)
    return np.asarray(away + away.T < kept[:, None] + kept)


def _goes_on(found: SwapEvidence, mine: Rows, others: Rows, own: tuple[Rows, Rows]) -> Mask:
    """Return which samples (r,) join candidates of others (m,) that are nearer than their own, (r, m)."""
    candidates = found.candidates[others]
    away = _distances(found.pos[mine], candidates["last_pos"])
    joins = joins_candidates(candidates, found.t, away, found.limits)
    return joins & _less(np.where(joins, away, np.inf), own)


def _moves_along(found: SwapEvidence, mine: Rows, others: Rows, own: tuple[Rows, Rows]) -> Mask:
    """Return which candidates (r,) move as the others (m,) did, rather than as their own vehicles, (r, m)."""
    candidates, last = found.candidates[mine], found.last
    vel = np.where(last.coasting[:, None], last.vel, np.nan)
    differs = _distances(mean_velocity(candidates), vel[others])
    differs[own] -= OTHER_MOTION
    return (candidates["samples"] >= MOVING_SAMPLES)[:, None] & _less(differs, own)


def _distances(one: Array, other: Array) -> Array:
    """Return the distances of points (r, 3) to others (m, 3), (r, m)."""
    return np.asarray(np.linalg.norm(one[:, None] - other, axis=2))


def _less(values: Array, own: tuple[Rows, Rows]) -> Mask:
    """Return which values (r, m) are less than the own one of their row, (r, m)."""
    return np.asarray(values < values[own][:, None])
