"""Position tracks from motion capture with outliers: predict, gate, associate, correct.

The motion model is that of kalman_filter, with steady_gain at a constant period; the gates are
position_gates, all of q2q_model.estimation.position. Data association of a sample that its own track rejects,
in this order:

1. A track's first sample is accepted but not trusted. If the next one fails the gates, the track restarts
   there, and is not trusted until two more pass. It does not restart once the first of these has, nor if that
   sample fits the first one of another vehicle whose next one fails, too. Names are then exchanged in one of
   the two frames; those that last for as long as a vehicle may coast are right.
2. The sample may belong to another vehicle (label_swaps of q2q_model.estimation.association). A track that
   has accepted fewer than SETTLED samples of its own name accepts those of other names at most as often, or
   MOST_BORROWED times, so a wrong start is corrected. A settled one goes on by its motion alone: names that
   are exchanged for good are exchanged by the server, also while poses repeat (exchanged_repeats). Where such
   a sample is further than jump_max from a track that coasts, a second one must agree.
3. Rejected samples that stay together are a true jump (reacquisition, there): the track restarts there, as it
   does at a thaw (position_prediction); later if they may be of another vehicle (suspected_swaps).

Without samples a track coasts for `coast_s`; then it is lost, with its position held and zero velocity.
"""

import numpy as np

from q2q_model.estimation.association.label_swaps import swapped_sources
from q2q_model.estimation.association.outlier_thresholds import OutlierThresholds
from q2q_model.estimation.association.reacquisition import Reacquisition
from q2q_model.estimation.association.suspected_swaps import LastSample, Unmatched
from q2q_model.estimation.position.exchanged_repeats import with_exchanged_repeats
from q2q_model.estimation.position.kalman_filter import start
from q2q_model.estimation.position.position_prediction import Prediction, look_ahead
from q2q_model.estimation.position.position_steps import (
    NEEDS_ASSOCIATION,
    WHOLE,
    Association,
    Offered,
    TrackMemory,
    accept,
    follow_positions,
)
from q2q_model.estimation.position.steady_gain import PERIOD
from q2q_model.estimation.position.track_columns import TrackColumns, TrackParams, unseen
from q2q_model.estimation.position.track_update import TrackUpdate
from q2q_model.signals.values import Array, Mask, Rows

MOST_BORROWED = 35
"""Samples of other names that a track accepts though it has had fewer of its own: 0.35 s at 100 Hz, the time
for which a vehicle may coast, by which swaps have ended."""
SETTLED = 100
"""Samples of its own name after which a track is that vehicle's, whatever later ones are called: 1 s."""


class PositionTracks:
    """Position track of every vehicle."""

    def __init__(self, params: TrackParams, count: int) -> None:
        """Start `count` tracks without samples."""
        self._params, self._noise_var = params, params.position_noise**2
        self._reacquisition = Reacquisition(
            0, OutlierThresholds(params.pos_max, params.speed_max, params.jump_max)
        )
        self._table, self._clock = unseen(0), np.full(2, np.nan)
        self.grow(count)

    def grow(self, extra: int) -> None:
        """Add tracks without samples."""
        known, self._table = self._table, unseen(len(self._table) + extra)
        self._table[: len(known)] = known
        self._reacquisition.grow(extra)
        self._count_rows()
        self.update(0.0, np.full((len(self._table), 3), np.nan))  # loads the kernels before the first tick

    def keep(self, kept: Mask) -> None:
        """Forget all tracks but some, (n,)."""
        self._table = self._table[kept]
        self._reacquisition.keep(kept)
        self._count_rows()

    def _count_rows(self) -> None:
        count = len(self._table)
        self._clock[PERIOD] = np.nan
        self._none, self._all = np.zeros(count, np.bool_), np.ones(count, np.bool_)
        self._rows = np.arange(count)

    @property
    def _tracks(self) -> TrackColumns:
        """Return the columns of the table, views of it."""
        return TrackColumns(*(self._table[name] for name in TrackColumns._fields))

    @property
    def confirmed(self) -> Mask:
        """Return the tracks that were trusted once, (n,)."""
        return self._tracks.confirmed.copy()

    @property
    def memory(self) -> TrackMemory:
        """Return the tracks in tables, which stay the same until tracks are added or forgotten."""
        return TrackMemory(self._table, self._reacquisition.candidates, self._clock)

    def set_back(self, by: float) -> None:
        """Set the times of all samples back by `by` [s], as the clock was."""
        self._tracks.time[:] -= by
        self._tracks.since[:] -= by
        self._reacquisition.set_back(by)
        self._clock[PERIOD] = np.nan

    def allow_gap(self, longest: float) -> None:
        """Let rejected samples stay together that are up to `longest` [s] apart."""
        self._reacquisition.gap_max = longest

    def age(self, t: float) -> Array:
        """Return the time since each track's last accepted sample [s], (n,); infinite if never seen."""
        return np.where(self._tracks.seen, t - self._tracks.time, np.inf)

    def update(self, t: float, measured: Array, repeated: Mask | None = None) -> TrackUpdate:
        """Return the tracks after one tick's samples.

        Args:
            t: Capture time [s], later than before.
            measured: Positions [m], (n, 3); NaN where absent.
            repeated: Poses that equal a recent one bit for bit, (n,); None where none does.
        """
        samples = measured.copy()  # of one layout for the kernels, whatever they are cut from
        repeats, pos, vel = self._none if repeated is None else repeated, *np.empty((2, *samples.shape))
        offered = Offered(samples, repeats, repeated is None)
        outcome = follow_positions(t, offered, self._params, self.memory, (pos, vel))
        if outcome != NEEDS_ASSOCIATION:
            return self.followed(outcome, samples, pos, vel)
        return self.associated(t, samples, repeats)

    def associated(self, t: float, samples: Array, repeats: Mask) -> TrackUpdate:
        """Return the tracks after the samples of a tick that `follow_positions` did not take, as `update`."""
        at = look_ahead((t, np.nan), samples, repeats, self._params, self._table)
        if repeats.any():
            at = with_exchanged_repeats(at, samples, self._tracks.seen)
        assigned = self._associate(t, at)
        pos, vel = accept(t, at, assigned, self._noise_var, self._table)
        self._clock[PERIOD] = np.nan
        trusted = (assigned.source >= 0) & self._tracks.confirmed & (~at.doubtful | assigned.jumped)
        return TrackUpdate(pos, vel, assigned.source, assigned.jumped, trusted, at.frozen, nominal=False)

    def followed(self, outcome: int, measured: Array, pos: Array, vel: Array) -> TrackUpdate:
        """Return the result of a tick that `follow_positions` took, (n, 3) each."""
        if outcome == WHOLE:
            return TrackUpdate(pos, vel, self._rows, self._none, self._all, self._none, nominal=True)
        present = _present(measured)
        source = np.where(present, self._rows, -1)
        return TrackUpdate(pos, vel, source, self._none, present, self._none, nominal=False)

    def _associate(self, t: float, at: Prediction) -> Association:
        """Assign samples to tracks."""
        tracks, own, rows = self._tracks, at.own, self._rows
        present = _present(at.samples)
        began = present & (~tracks.seen | self._refutes_first(at, present))
        rejected = present & ~own & ~began
        source = np.where(own | began, rows, -1)
        if rejected.any():
            known = tracks.seen & (tracks.confirmed | ~present)
            missing = known & ~at.lost & ~own & _may_borrow(tracks)
            borrowed = swapped_sources(at.samples, at.state[:, 0], at.reach, rejected, missing)
            borrowed = np.where(self._by_chance(t, at, borrowed), -1, borrowed)
            source = np.where(borrowed >= 0, borrowed, source)
            rejected &= (source < 0) & ~np.isin(rows, borrowed)
        self._reacquisition.forget(source >= 0)
        absent = tracks.seen & (~present | ((source < 0) & ~rejected))
        unmatched = Unmatched(absent, rejected)
        jumped = self._jumped(t, at, unmatched)
        if (began | jumped | at.thawed).any():
            self._restart(t, at, began | jumped | at.thawed, jumped)
        return Association(np.where(jumped, rows, source), began, jumped | at.thawed)

    def _by_chance(self, t: float, at: Prediction, borrowed: Rows) -> Mask:
        """Return the tracks whose sample of another name may be an outlier that is there by chance, (n,).

        It is further than jump_max from the prediction of a track that coasts, and the first one there.
        """
        away = np.linalg.norm(at.samples[borrowed] - at.state[:, 0], axis=1)
        first = ~self._reacquisition.joins(t, at.samples)[borrowed]
        return np.asarray((borrowed >= 0) & (away > self._params.jump_max) & first)

    def _refutes_first(self, at: Prediction, present: Mask) -> Mask:
        """Return the samples that show the unconfirmed first one of their tracks to be wrong, (n,).

        Not where rejected samples gather already, or one that refuted another has been followed by one that
        fits it, since one more might be an outlier, nor where they fit a track without an own sample, whose
        they may be.
        """
        tracks = self._tracks
        supported = tracks.confirmed | (tracks.refuted & (tracks.own > 0))
        fails = present & tracks.seen & ~at.own & ~supported
        if not fails.any():
            return fails
        fits = np.linalg.norm(at.samples[:, None] - at.state[None, :, 0], axis=2) <= at.reach
        alone = self._reacquisition.candidates["samples"] == 0
        without = fails | (tracks.seen & ~present)
        return np.asarray(fails & alone & ~(fits & without).any(axis=1))

    def _jumped(self, t: float, at: Prediction, unmatched: Unmatched) -> Mask:
        """Return the tracks whose rejected samples are accepted, (n,).

        Those that may be another vehicle's, or repeat a pose as a frozen stream does, have to last.
        """
        if not unmatched.rejected.any():
            return unmatched.rejected
        tracks, params = self._tracks, self._params
        last = LastSample(tracks.state[:, 0], tracks.state[:, 1], tracks.time, ~at.lost)
        ambiguous = self._reacquisition.update_ambiguous(t, at.samples, last, unmatched)
        ambiguous &= ~tracks.confirmed | _may_borrow(tracks)
        longest = max(params.coast_s, params.reacquire_s)
        patience = np.where(ambiguous | at.repeated, longest, params.reacquire_s)
        return self._reacquisition.offer(t, at.samples, unmatched.rejected, patience)

    def _restart(self, t: float, at: Prediction, fresh: Mask, jumped: Mask) -> None:
        """Start tracks at their own samples."""
        velocity = self._velocity_since_last(t, at)
        velocity = np.where(jumped[:, None], self._reacquisition.velocity(), velocity)
        state, cov = start(at.samples[fresh], velocity[fresh], self._noise_var)
        self._tracks.state[fresh], self._tracks.cov[fresh] = state, cov
        self._reacquisition.forget(jumped)

    def _velocity_since_last(self, t: float, at: Prediction) -> Array:
        """Return the velocity from the last samples to these [m/s], (n, 3); zero beyond speed_max.

        Of samples that repeat, the first one counts.
        """
        tracks = self._tracks
        elapsed = np.where(tracks.seen, t - np.where(at.thawed, tracks.since, tracks.time), np.inf)
        velocity = (at.samples - tracks.state[:, 0]) / elapsed[:, None]
        slow = np.linalg.norm(velocity, axis=1) <= self._params.speed_max
        return np.where(slow[:, None], velocity, 0.0)


def _may_borrow(tracks: TrackColumns) -> Mask:
    """Return the tracks that may accept samples of other names, (n,)."""
    return np.asarray((tracks.own >= SETTLED) | (tracks.borrowed < np.maximum(tracks.own, MOST_BORROWED)))


def _present(samples: Array) -> Mask:
    return np.asarray(~np.isnan(samples).any(axis=1))
