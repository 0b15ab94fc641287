"""Track positions through motion capture that lies: gate, coast, swap back, re-acquire.

The motion between samples and its spread come from q2q_model.estimation.white_jerk. A sample r of a vehicle
last seen at p, tau ago, is taken when it passes all three, with the thresholds of q2q_model.flights.outliers:

    room      max |r| <= pos_max
    velocity  |r - p| <= jump_max + speed_max tau
    position  |r - p-| <= jump_max + GATE_SIGMAS sqrt(S)     once lost, none passes

A pose that is the last one again to the last digit, though the vehicle was moving or the pose is refused, is
an old frame under a new stamp: no sample, for as long as the vehicle coasts. A refused sample is tried as
another vehicle's marker (q2q_model.estimation.marker_swaps). A track takes others' markers for at most as
many samples as it had been right about its name, so a wrong start heals. What is still refused but stays
together is a true jump (q2q_model.estimation.reacquisition): the track starts there. A track's first sample
is taken for lack of a better one, but not trusted: where the next one does not follow from it, the track
starts anew there. Without samples a track coasts for `coast_s`; then it is lost, its position held and its
velocity zero.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from q2q_model.estimation import white_jerk
from q2q_model.estimation.marker_swaps import swapped_sources
from q2q_model.estimation.partial_frame import EXPECTED, SPREAD, WIDTH, expect_all, follow_present
from q2q_model.estimation.reacquisition import SAME_INSTANT, Lacking, Reacquisition
from q2q_model.estimation.sample_fate import SampleFates
from q2q_model.estimation.track_rows import padded
from q2q_model.estimation.usual_frame import glide_positions
from q2q_model.flights.outliers import REPEAT_STEP, Mask, OutlierThresholds
from q2q_model.signals.values import Array

GATE_SIGMAS = 1.0
"""Width of the position gate beyond jump_max, in standard deviations of the prediction: after a dropout an
outlier does more harm than the moment that a rival needs to be believed."""
STEADY = 1e-9
"""Relative change of the covariance in a tick below which its gains are settled."""


@dataclass(frozen=True, slots=True)
class TrackParams:
    """Filter parameters that PositionTracks needs."""

    limits: OutlierThresholds
    position_noise: float
    """[m]"""
    jerk_noise: float
    """[m/s^2.5]"""
    coast_s: float
    reacquire_s: float


@dataclass(frozen=True, slots=True)
class _Ahead:
    """Predictions of the tracks at a tick."""

    state: Array
    cov: Array
    lost: Mask
    gate: Array
    """Largest believable distance from the expected position [m], (n,)."""
    reach: Array
    """Largest believable distance from the last position [m], (n,)."""


@dataclass(slots=True)
class _Steady:
    """Steady-state gains: evenly spaced samples give the same ones again."""

    t: float
    """The last tick [s]."""
    dt: float
    """The spacing they belong to [s]."""
    gain: Array
    """K, (n, 3)."""
    moving: Array
    """F and the gates, as of glide.glide_positions, (7,)."""
    ticks: int = 0
    """How many were taken by them, and are not written down yet."""


class PositionTracks:
    """Position track of every vehicle."""

    def __init__(self, params: TrackParams, count: int) -> None:
        """Start `count` vehicles, none of them seen."""
        self._params = params
        self._noise_var = params.position_noise**2
        self._seen: Mask = np.zeros(count, dtype=bool)
        self._proven: Mask = np.zeros(count, dtype=bool)  # a second sample has confirmed the first
        self._time: Array = np.zeros(count)
        self._state: Array = np.zeros((count, 3, 3))
        self._cov: Array = np.zeros((count, 3, 3))
        self._reacquisition = Reacquisition(count, params.limits)
        self._right = np.zeros(count, dtype=np.int64)  # samples taken under its own name
        self._swapped = np.zeros(count, dtype=np.int64)  # samples taken from others since
        limits = params.limits
        self._numbers = np.array(
            [
                *(self._noise_var, params.jerk_noise**2, params.coast_s),
                *(limits.jump_max, limits.speed_max, GATE_SIGMAS, limits.pos_max, SAME_INSTANT),
            ]
        )
        self._settle_rows(count)
        none, still = np.zeros((0, 7)), np.zeros((0, 3, 3))
        glide_positions((none, none), still, np.zeros((0, 3)), np.zeros(7), np.zeros((0, 13)))  # loads it

    def grow(self, extra: int) -> None:
        """Add vehicles that were never seen."""
        self._settle()
        self._seen, self._time = padded(self._seen, extra), padded(self._time, extra)
        self._proven = padded(self._proven, extra)
        self._state, self._cov = padded(self._state, extra), padded(self._cov, extra)
        self._right, self._swapped = padded(self._right, extra), padded(self._swapped, extra)
        self._reacquisition.grow(extra)
        self._settle_rows(len(self._seen))

    def _settle_rows(self, count: int) -> None:
        self._rows, self._every = np.arange(count), np.ones(count, dtype=bool)
        self._work, self._out = np.empty((count, WIDTH)), np.empty((count, 6))
        self._steady: _Steady | None = None

    def age(self, t: float) -> Array:
        """Return the time since each vehicle's last taken sample [s], (n,); infinite if never."""
        return np.where(self._seen, t - self._time, np.inf)

    def update(self, t: float, measured: Array, repeated: Mask | None = None) -> SampleFates:
        """Judge one tick's samples.

        Args:
            t: Capture time [s], later than before.
            measured: Positions [m], (n, 3); NaN where absent.
            repeated: Whose pose is the last one again to the last digit, (n,); None where nobody's is.
        """
        self._settle()
        if repeated is None and (verdict := self._follow(t, measured)) is not None:
            return verdict
        ahead = self._expect(t)
        inside = np.where(np.abs(measured) <= self._params.limits.pos_max, measured, np.nan)
        fits = self._judge(inside, ahead)
        if repeated is not None:
            old = repeated & ~ahead.lost & (~fits | self._moves(ahead.state))
            inside, fits = np.where(old[:, None], np.nan, inside), fits & ~old
        self._steady = None
        return self._sort_out(t, inside, ahead, fits)

    def glide(self, t: float, poses: tuple[Array, Array], out: Array) -> bool:
        """Take a whole tick with the gains of the last, where nothing is unusual; else return False.

        Args:
            t: Capture time [s], later than before.
            poses: Positions and quaternions of this frame and of the last, (n, 7) each.
            out: Where positions and velocities are written, (n, 13).
        """
        steady = self._steady
        if steady is None or abs(t - steady.t - steady.dt) > SAME_INSTANT:
            return False
        if not glide_positions(poses, self._state, steady.gain, steady.moving, out):
            return False
        steady.t = t
        steady.ticks += 1
        return True

    def _settle(self) -> None:
        """Write down what `glide` left aside."""
        steady = self._steady
        if steady is not None and steady.ticks:
            self._taken(steady.t, steady.ticks)
            steady.ticks = 0

    def _moves(self, expected: Array) -> Mask:
        return np.asarray(np.abs(expected[:, 0] - self._state[:, 0]).max(axis=1) > REPEAT_STEP)

    def _follow(self, t: float, measured: Array) -> SampleFates | None:
        """Take a tick in which some may be absent and nothing else is unusual; else return None."""
        if not self._proven.all():
            return None
        since, before = t - self._time, self._cov.copy()
        if not follow_present(
            measured, (since, self._state, self._cov), self._numbers, self._work, self._out
        ):
            return None
        self._steady = None  # gains of another spacing must not come back once their next tick would be due
        taken: Mask = np.asarray(~np.isnan(measured).any(axis=1))
        plain = bool(taken.all())
        if plain:
            self._taken(t, 1)
            self._note_steady(t, since, before)
        else:
            self._time[taken] = t
            self._right += taken
            self._swapped[taken] = 0
            self._reacquisition.forget(taken)
        pos, vel, source = self._out[:, :3].copy(), self._out[:, 3:].copy(), np.where(taken, self._rows, -1)
        return SampleFates(pos, vel, taken, source, ~self._every, taken, plain=plain, none_rejected=True)

    def _note_steady(self, t: float, since: Array, before: Array) -> None:
        """Note the gains of a whole tick, where they are the last one's."""
        even = len(since) > 0 and np.ptp(since) < SAME_INSTANT and since[0] <= self._params.coast_s
        if even and np.all(np.abs(self._cov - before) <= STEADY * np.abs(before).max(axis=0)):
            self._steady = _Steady(t, float(since[0]), *self._settled_gains(since))

    def _settled_gains(self, since: Array) -> tuple[Array, Array]:
        """Return K and what else `glide` needs of the motion, which all vehicles share."""
        expected = self._work[:, SPREAD].reshape(-1, 3, 3)
        limits, (moved, _) = self._params.limits, white_jerk.transition(since[:1], 0.0)
        gate = limits.jump_max + GATE_SIGMAS * math.sqrt(float(expected[:, 0, 0].min()) + self._noise_var)
        reach = limits.jump_max + limits.speed_max * float(since[0])
        sides = gate / math.sqrt(3.0), reach / math.sqrt(3.0)
        exact = float(self._noise_var == 0.0)
        moving = np.array([*moved[0][[0, 0, 1], [1, 2, 2]], *sides, limits.pos_max, exact])
        return white_jerk.gain(expected, self._noise_var), moving

    def _taken(self, t: float, ticks: int) -> None:
        """Write down that every vehicle's own sample was taken, `ticks` times, the last one at t [s]."""
        self._time[:] = t
        self._proven[:] = True
        self._right += ticks
        self._swapped[:] = 0
        self._reacquisition.forget(self._every)

    def _expect(self, t: float) -> _Ahead:
        elapsed = np.where(self._seen, t - self._time, 0.0)
        limits = self._params.limits
        expect_all((elapsed, self._state, self._cov), self._numbers, self._work)
        state, cov = (self._work[:, part].reshape(-1, 3, 3).copy() for part in (EXPECTED, SPREAD))
        gate = limits.jump_max + GATE_SIGMAS * np.sqrt(cov[:, 0, 0] + self._noise_var)
        reach = limits.jump_max + limits.speed_max * elapsed
        return _Ahead(state, cov, elapsed > self._params.coast_s + SAME_INSTANT, gate, reach)

    def _judge(self, measured: Array, ahead: _Ahead) -> Mask:
        miss, step = measured - ahead.state[:, 0], measured - self._state[:, 0]
        near = (np.sum(miss * miss, axis=1) <= ahead.gate**2) & ~ahead.lost
        fits = near & (np.sum(step * step, axis=1) <= ahead.reach**2)
        return np.where(self._seen, fits, ~np.isnan(measured).any(axis=1))

    def _sort_out(self, t: float, measured: Array, ahead: _Ahead, fits: Mask) -> SampleFates:
        present = ~np.isnan(measured).any(axis=1)
        began = present & (~self._seen | (~fits & ~self._proven))
        orphans = present & ~fits & ~began
        trusting = self._seen & ~ahead.lost & ~fits & ~began & (self._swapped < self._right)
        gate = np.minimum(ahead.gate, ahead.reach)
        lent = swapped_sources(measured, ahead.state[:, 0], gate, orphans, trusting)
        source = np.where(lent >= 0, lent, np.where(fits | began, self._rows, -1))
        self._reacquisition.forget(source >= 0)
        lending = ~self._every
        lending[lent[lent >= 0]] = True
        refused = orphans & (source < 0) & ~lending
        lacking = Lacking(~present & self._seen, refused)
        usual, longest = self._params.reacquire_s, max(self._params.coast_s, self._params.reacquire_s)
        doubtful = self._reacquisition.doubtful(t, measured, (self._state[:, 0], self._time), lacking)
        doubtful &= self._swapped < self._right
        jumped = self._reacquisition.offer(t, measured, refused, np.where(doubtful, longest, usual))
        source = np.where(jumped, self._rows, source)
        self._proven = (self._proven | jumped | fits) & ~began
        self._count(fits, lent >= 0, jumped | began)
        self._take(t, measured[source], ahead, (source >= 0, jumped | began, jumped))
        return self._verdict(ahead, source, jumped)

    def _count(self, own: Mask, lent: Mask, fresh: Mask) -> None:
        self._swapped = np.where(lent, self._swapped + 1, np.where(own, 0, self._swapped))
        self._right = np.where(fresh, 1, self._right + own)

    def _take(self, t: float, samples: Array, ahead: _Ahead, masks: tuple[Mask, Mask, Mask]) -> None:
        taken, fresh, jumped = masks
        on = taken & ~fresh
        self._state[on], self._cov[on] = white_jerk.correct(
            ahead.state[on], ahead.cov[on], samples[on], self._noise_var
        )
        if fresh.any():
            velocity = np.where(
                jumped[:, None], self._reacquisition.velocity(), self._since_first(t, samples)
            )
            self._state[fresh], self._cov[fresh] = white_jerk.start(
                samples[fresh], velocity[fresh], self._noise_var
            )
        self._time[taken] = t
        self._seen |= taken
        self._reacquisition.forget(jumped)

    def _since_first(self, t: float, samples: Array) -> Array:
        """Return the velocity from the last samples to these [m/s], (n, 3); zero beyond belief."""
        elapsed = np.where(self._seen, t - self._time, np.inf)
        velocity = (samples - self._state[:, 0]) / elapsed[:, None]
        slow = np.linalg.norm(velocity, axis=1) <= self._params.limits.speed_max
        return np.where(slow[:, None], velocity, 0.0)

    def _verdict(self, ahead: _Ahead, source: NDArray[np.intp], jumped: Mask) -> SampleFates:
        taken = source >= 0
        state = np.where(taken[:, None, None], self._state, ahead.state)
        vel = np.where((ahead.lost & ~taken)[:, None], 0.0, state[:, 1])
        trusted = taken & self._proven
        return SampleFates(
            state[:, 0].copy(), vel, taken, source, jumped, trusted, plain=False, none_rejected=False
        )
