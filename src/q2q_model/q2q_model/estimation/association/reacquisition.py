"""Reacquisition after a true jump: rejected samples that stay together are accepted.

A rejected sample joins the candidate of its track (jump_candidates), or starts a new one. A candidate with
CONFIRM_SAMPLES samples that has lasted for the required time becomes the track, unless more than half of that
is one gap: those before and after it may have met by chance.
"""

import numpy as np

from q2q_model.estimation.association.jump_candidates import (
    CANDIDATE,
    GAP_S,
    Table,
    joins_candidates,
    mean_velocity,
)
from q2q_model.estimation.association.outlier_thresholds import OutlierThresholds
from q2q_model.estimation.association.suspected_swaps import (
    LastSample,
    SwapEvidence,
    Unmatched,
    suspected_swaps,
)
from q2q_model.signals.stamps import SAME_INSTANT
from q2q_model.signals.values import Array, Mask

CONFIRM_SAMPLES = 3
"""Minimum number of samples of an accepted jump, whatever their rate."""


class Reacquisition:
    """Candidates for a restart."""

    def __init__(self, count: int, limits: OutlierThresholds) -> None:
        """Start `count` tracks without candidates."""
        self._limits = limits
        self._candidates = np.zeros(count, CANDIDATE)
        self.gap_max = GAP_S
        """Longest time from the samples that are offered to those that join them [s]."""

    @property
    def candidates(self) -> Table:
        """Return the candidates, CANDIDATE (n,), which stay in this table until they grow."""
        return self._candidates

    def grow(self, extra: int) -> None:
        """Add tracks without candidates."""
        self._candidates = np.concatenate([self._candidates, np.zeros(extra, CANDIDATE)])

    def keep(self, kept: Mask) -> None:
        """Forget all tracks but some, (n,)."""
        self._candidates = self._candidates[kept]

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
        one, joins = self._candidates, rejected & self.joins(t, pos)
        starts = rejected & ~joins
        one["first_time"][starts], one["first_pos"][starts] = t, pos[starts]
        one["gap"][starts] = 0.0
        one["gap"][joins] = np.maximum(one["gap"], t - one["last_time"])[joins]
        one["last_time"][rejected], one["last_pos"][rejected] = t, pos[rejected]
        one["gap_max"][rejected] = self.gap_max
        one["samples"][starts] = 1
        one["samples"][joins] += 1
        lasted = t - one["first_time"] >= patience - SAME_INSTANT
        steady = one["gap"] <= 0.5 * (t - one["first_time"]) + SAME_INSTANT
        return np.asarray(rejected & lasted & steady & (one["samples"] >= CONFIRM_SAMPLES))

    def update_ambiguous(self, t: float, pos: Array, last: LastSample, unmatched: Unmatched) -> Mask:
        """Update and return which samples at pos [m] (n, 3) may be of another vehicle, misnamed, (n,).

        A candidate that was ambiguous remains so while any other vehicle is without an accepted sample. Swaps
        end before a vehicle has coasted.
        """
        noted = self._candidates["ambiguous"]
        noted &= unmatched.either.sum() > unmatched.either  # another one
        noted &= self.joins(t, pos) | ~unmatched.rejected
        noted |= suspected_swaps(SwapEvidence(t, pos, last, self._candidates, self._limits), unmatched)
        return noted.copy()

    def velocity(self) -> Array:
        """Return the mean velocity of every candidate [m/s], (n, 3); zero for a single sample."""
        return mean_velocity(self._candidates)

    def joins(self, t: float, pos: Array) -> Mask:
        """Return which samples at pos [m] (n, 3) join the candidates of their rows, (n,)."""
        away = np.linalg.norm(pos - self._candidates["last_pos"], axis=-1)
        return joins_candidates(self._candidates, t, away, self._limits)
