"""Position tracks from motion capture with outliers: predict, gate, associate, correct.

The motion model is q2q_model.estimation.white_jerk, with q2q_model.estimation.steady_gain at a constant
period; the gates are q2q_model.estimation.position_gates. Data association of a sample that its own track
rejects, in this order:

1. A track's first sample is accepted but not trusted: if the next one fails the gates, the track restarts
   there, unless that fits the first sample of another vehicle whose next one fails too: names are exchanged
   in one of the two frames, and those that last for as long as a vehicle may coast are right.
2. The sample may belong to another vehicle (q2q_model.estimation.marker_swaps). A track accepts samples of
   other names at most as often as it has accepted samples of its own name, or BORROWED_MOST times, so a
   wrong start is corrected.
3. Rejected samples that stay together are a true jump (q2q_model.estimation.reacquisition): the track
   restarts there.

Without samples a track coasts for `coast_s`; then it is lost, with its position held and zero velocity.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from q2q_model.compiled import compiled
from q2q_model.estimation.marker_swaps import swapped_sources
from q2q_model.estimation.position_gates import GATE_SIGMAS, PositionGates, screen
from q2q_model.estimation.reacquisition import SAME_INSTANT, Reacquisition, Unmatched
from q2q_model.estimation.steady_gain import SteadyGain, steady_gain
from q2q_model.estimation.track_columns import TrackColumns, TrackParams, unseen
from q2q_model.estimation.white_jerk import MotionEstimate, correct, gain, predict, start
from q2q_model.flights.outliers import Mask, OutlierThresholds
from q2q_model.signals.values import Array

Rows = NDArray[np.intp]

BORROWED_MOST = 35
"""Samples of other names that a track accepts though it has had fewer of its own: 0.35 s at 100 Hz, the time
for which a vehicle may coast, by which swaps have ended."""


@dataclass(frozen=True, slots=True)
class TrackUpdate:
    """Result of one tick, one row per vehicle."""

    pos: Array
    """Position [m], (n, 3); zero for a vehicle never seen."""
    vel: Array
    """Velocity [m/s], (n, 3); zero for a lost vehicle."""
    source: NDArray[np.intp]
    """Row of the accepted sample, (n,): another row where markers were swapped, -1 where none."""
    restarted: Mask
    """TrackColumns restarted at a true jump, (n,)."""
    trusted: Mask
    """TrackColumns with an accepted sample that are confirmed, (n,)."""
    nominal: bool
    """Every track is confirmed, and accepted the sample of its own name."""

    @property
    def accepted(self) -> Mask:
        """Return which tracks accepted a sample, (n,)."""
        return np.asarray(self.source >= 0)

    @property
    def lent(self) -> Mask:
        """Return which tracks accepted a sample of another name, (n,)."""
        return np.asarray(self.accepted & (self.source != np.arange(len(self.source))))


class Prediction(NamedTuple):
    """TrackColumns predicted to a tick, and the samples that pass their gates."""

    elapsed: Array
    """Time since each track's last sample [s], (n,)."""
    state: Array
    """As in white_jerk, (n, 3, 3)."""
    cov: Array
    """(n, 3, 3)"""
    K: Array
    """Gain of a correction, (n, 3)."""
    samples: Array
    """Positions [m], (n, 3); NaN where there is no sample."""
    own: Mask
    """TrackColumns whose own sample passes the gates, (n,)."""
    reach: Array
    """Largest believable distance of a sample from the prediction [m], (n,)."""
    lost: Mask
    """TrackColumns without a sample for longer than coast_s, (n,)."""
    nominal: bool
    """Every track is confirmed, and its own sample passes the gates."""


class Association(NamedTuple):
    """Samples assigned to tracks."""

    source: Rows
    """As TrackUpdate.source."""
    began: Mask
    """TrackColumns that start, or restart after an unconfirmed first sample, (n,)."""
    jumped: Mask
    """TrackColumns that restart at a true jump, (n,)."""


class PositionTracks:
    """Position track of every vehicle."""

    def __init__(self, params: TrackParams, count: int) -> None:
        """Start `count` tracks without samples."""
        self._params = params
        self._noise_var = params.position_noise**2
        self._tracks = unseen(0)
        self._reacquisition = Reacquisition(
            0, OutlierThresholds(params.pos_max, params.speed_max, params.jump_max)
        )
        self.grow(count)

    def grow(self, extra: int) -> None:
        """Add tracks without samples."""
        pairs = zip(self._tracks, unseen(extra), strict=True)
        self._tracks = TrackColumns(*(np.concatenate(pair) for pair in pairs))
        self._reacquisition.grow(extra)
        count = len(self._tracks.seen)
        self._none, self._all = np.zeros(count, np.bool_), np.ones(count, np.bool_)
        self._all_own = Association(np.arange(count), self._none, self._none)
        never = SteadyGain(np.zeros((count, 3)), 0.0, -np.inf)
        self._follow(0.0, np.zeros((count, 3)), self._none, never)  # loads the kernel before the first tick
        self._steady: SteadyGain | None = None

    def set_back(self, by: float) -> None:
        """Set the times of all samples back by `by` [s], as the clock was."""
        self._tracks.time[:] -= by
        self._reacquisition.set_back(by)
        self._steady = None

    def age(self, t: float) -> Array:
        """Return the time since each track's last accepted sample [s], (n,); infinite if never seen."""
        return np.where(self._tracks.seen, t - self._tracks.time, np.inf)

    def update(self, t: float, measured: Array, repeated: Mask | None = None) -> TrackUpdate:
        """Return the tracks after one tick's samples.

        Args:
            t: Capture time [s], later than before.
            measured: Positions [m], (n, 3); NaN where absent.
            repeated: Poses that equal the last frame's bit for bit, (n,); None where no x does.
        """
        samples = measured.copy()  # of one layout for the kernels, whatever they are cut from
        repeats, steady = self._none if repeated is None else repeated, self._steady
        if steady is not None and steady.is_due(t):
            followed = self._follow(t, samples, repeats, steady)
            if followed is not None:
                return followed
        at = Prediction(*look_ahead((t, np.nan), samples, repeats, self._params, self._tracks))
        assigned, cov = self._associate(t, at), self._tracks.cov.copy()
        pos, vel = accept(t, at, assigned, self._noise_var, self._tracks)
        self._steady = None
        if at.nominal and repeated is None:
            self._steady = steady_gain(at.K, (t, at.elapsed), (cov, self._tracks.cov))
        trusted = (assigned.source >= 0) & self._tracks.confirmed
        return TrackUpdate(pos, vel, assigned.source, assigned.jumped, trusted, at.nominal)

    def _follow(self, t: float, samples: Array, repeated: Mask, steady: SteadyGain) -> TrackUpdate | None:
        """Return the tracks after a nominal tick; None, and no track changed, if it is not nominal."""
        nominal, pos, vel = follow(t, (samples, repeated), steady, self._params, self._tracks)
        if not nominal:
            return None
        self._reacquisition.forget(self._all)
        self._steady = SteadyGain(steady.K, steady.period, t)
        return TrackUpdate(pos, vel, self._all_own.source, self._none, self._all, nominal=True)

    def _associate(self, t: float, at: Prediction) -> Association:
        """Assign samples to tracks."""
        tracks, own, rows = self._tracks, at.own, self._all_own.source
        if at.nominal:
            self._reacquisition.forget(own)
            return self._all_own
        present = _present(at.samples)
        began = present & (~tracks.seen | self._refutes_first(at, present))
        rejected = present & ~own & ~began
        source = np.where(own | began, rows, -1)
        if rejected.any():
            known = tracks.seen & (tracks.confirmed | ~present)
            missing = known & ~at.lost & ~own & _may_borrow(tracks)
            borrowed = swapped_sources(at.samples, at.state[:, 0], at.reach, rejected, missing)
            source = np.where(borrowed >= 0, borrowed, source)
            rejected &= (source < 0) & ~np.isin(rows, borrowed)
        self._reacquisition.forget(source >= 0)
        unmatched = Unmatched(~present & tracks.seen, rejected)
        jumped = self._jumped(t, at.samples, unmatched)
        if (began | jumped).any():
            self._restart(t, at.samples, began | jumped, jumped)
        return Association(np.where(jumped, rows, source), began, jumped)

    def _refutes_first(self, at: Prediction, present: Mask) -> Mask:
        """Return the samples that show the unconfirmed first one of their tracks to be wrong, (n,)."""
        tracks = self._tracks
        fails = present & tracks.seen & ~at.own & ~tracks.confirmed
        if not fails.any():
            return fails
        fits = np.linalg.norm(at.samples[:, None] - at.state[None, :, 0], axis=2) <= at.reach
        return np.asarray(fails & ~(fits & fails).any(axis=1))

    def _jumped(self, t: float, samples: Array, unmatched: Unmatched) -> Mask:
        """Return the tracks whose rejected samples are accepted, (n,)."""
        if not unmatched.rejected.any():
            return unmatched.rejected
        tracks, params = self._tracks, self._params
        last = tracks.state[:, 0], tracks.time
        ambiguous = self._reacquisition.ambiguous(t, samples, last, unmatched)
        ambiguous &= ~tracks.confirmed | _may_borrow(tracks)
        longest = max(params.coast_s, params.reacquire_s)
        patience = np.where(ambiguous, longest, params.reacquire_s)
        return self._reacquisition.offer(t, samples, unmatched.rejected, patience)

    def _restart(self, t: float, samples: Array, fresh: Mask, jumped: Mask) -> None:
        """Start tracks at their own samples."""
        velocity = np.where(
            jumped[:, None], self._reacquisition.velocity(), self._velocity_since_last(t, samples)
        )
        state, cov = start(samples[fresh], velocity[fresh], self._noise_var)
        self._tracks.state[fresh], self._tracks.cov[fresh] = state, cov
        self._reacquisition.forget(jumped)

    def _velocity_since_last(self, t: float, samples: Array) -> Array:
        """Return the velocity from the last samples to these [m/s], (n, 3); zero beyond speed_max."""
        tracks = self._tracks
        elapsed = np.where(tracks.seen, t - tracks.time, np.inf)
        velocity = (samples - tracks.state[:, 0]) / elapsed[:, None]
        slow = np.linalg.norm(velocity, axis=1) <= self._params.speed_max
        return np.where(slow[:, None], velocity, 0.0)


@compiled(error_model="numpy")
def look_ahead(
    tick: tuple[float, float], measured: Array, repeated: Mask, params: TrackParams, tracks: TrackColumns
) -> tuple[Array, Array, Array, Array, Array, Mask, Array, Mask, bool]:
    """Return the columns of a Prediction.

    Args:
        tick: Time [s], and the steady period of all tracks [s]; NaN without.
        measured: Positions [m], (n, 3); NaN where absent.
        repeated: Poses that equal the last frame's bit for bit, (n,).
        params: Parameters.
        tracks: TrackColumns.
    """
    t, period = tick
    elapsed = np.where(tracks.seen, t - tracks.time, 0.0)
    if not np.isnan(period):
        elapsed[:] = period
    noise_var = params.position_noise**2
    coasted = np.minimum(elapsed, params.coast_s)
    ahead = predict(MotionEstimate(tracks.state, tracks.cov), coasted, params.jerk_noise**2)
    gates = PositionGates(
        last=tracks.state[:, 0],
        expected=ahead.state[:, 0],
        reach=params.jump_max + params.speed_max * elapsed,
        deviation=params.jump_max + GATE_SIGMAS * np.sqrt(ahead.cov[:, 0, 0] + noise_var),
        lost=elapsed > params.coast_s + SAME_INSTANT,
        pos_max=params.pos_max,
    )
    samples, passed = screen(measured, repeated, gates)
    own, reach = passed & tracks.seen, np.minimum(gates.deviation, gates.reach)
    nominal = bool((own & tracks.confirmed).all())
    return elapsed, ahead.state, ahead.cov, gain(ahead, noise_var), samples, own, reach, gates.lost, nominal


@compiled
def accept(
    t: float, at: Prediction, assigned: Association, noise_var: float, tracks: TrackColumns
) -> tuple[Array, Array]:
    """Take the assigned samples into the tracks; return positions and velocities, (n, 3) each."""
    better = correct(MotionEstimate(at.state, at.cov), at.samples[assigned.source], at.K, noise_var)
    pos, vel = np.empty_like(at.samples), np.zeros_like(at.samples)
    for i, source in enumerate(assigned.source):
        if source < 0:
            pos[i] = at.state[i, 0]
            if not at.lost[i]:
                vel[i] = at.state[i, 1]
            continue
        tracks.seen[i], tracks.time[i] = True, t
        if assigned.began[i] or assigned.jumped[i]:
            tracks.own[i], tracks.confirmed[i] = 1, assigned.jumped[i]
        else:
            tracks.state[i], tracks.cov[i] = better.state[i], better.cov[i]
            if source == i:
                tracks.own[i] += 1
                tracks.borrowed[i], tracks.confirmed[i] = 0, True
            else:
                tracks.borrowed[i] += 1
        pos[i], vel[i] = tracks.state[i, 0], tracks.state[i, 1]
    return pos, vel


@compiled
def follow(
    t: float, offered: tuple[Array, Mask], steady: SteadyGain, params: TrackParams, tracks: TrackColumns
) -> tuple[bool, Array, Array]:
    """Take one tick's samples at the steady gain, in one call; the covariance stands still.

    Return whether the tick is nominal, else no track has changed, and positions and velocities, (n, 3) each.
    `offered` is `measured` and `repeated` of look_ahead.
    """
    made = look_ahead((t, steady.period), offered[0], offered[1], params, tracks)
    elapsed, state, cov, _, samples, own, reach, lost, nominal = made
    if not nominal:
        return False, samples, samples
    at = Prediction(elapsed, state, cov, steady.K, samples, own, reach, lost, nominal)
    none, before = np.zeros(len(own), np.bool_), tracks.cov.copy()
    pos, vel = accept(t, at, Association(np.arange(len(own)), none, none), params.position_noise**2, tracks)
    tracks.cov[:] = before
    return True, pos, vel


def _may_borrow(tracks: TrackColumns) -> Mask:
    """Return the tracks that may accept samples of other names, (n,)."""
    return np.asarray(tracks.borrowed < np.maximum(tracks.own, BORROWED_MOST))


def _present(samples: Array) -> Mask:
    return np.asarray(~np.isnan(samples).any(axis=1))
