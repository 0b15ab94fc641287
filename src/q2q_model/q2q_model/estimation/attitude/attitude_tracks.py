"""Attitudes and body rates, robust to reflections that flip a rigid body.

A quaternion q, tau after the last accepted one q0, is accepted if its angle to q0 is at most turn_max +
turn_rate_max tau, where tau stops growing at the first rejection. A rejected attitude that lasts for
`reacquire_s` is accepted. The first attitude of a track is accepted once its body z points up: a vehicle that
is to fly is not upside down, a reflected rigid body and a quaternion w x y z are, and a controller that flew
by them would command the least thrust. For the same reason a turn by more than a right angle to upside down
is rejected after any gap, also after one by a jump of the clock, until it has lasted for `flip_reacquire_s`,
and a turn from upside down to upright is accepted at once: a vehicle that tumbles is seen to turn. q and -q
are one attitude: the sign nearest the last is kept. The body rate is the constant rate between successive
attitudes behind a first-order low-pass filter, so it lags by half a sample and the filter's time constant T:

    w_raw = log(q0* q) / tau,   w = w + tau / (tau + T) (w_raw - w)

In a dropout the attitude is held and the rate is zero. The ticks in which no attitude is new, rejected or
upside down are those of q2q_model.estimation.attitude.attitude_steps.

| symbol | name | meaning [unit] |
|---|---|---|
| q | quat | orientation x y z w, body to world |
| w | ang_vel_body | body rate [rad/s] |
| T | rate_filter_s | time constant of the rate [s]; 0 is none |
"""

import numpy as np

from q2q_model.estimation.association.jump_candidates import Table
from q2q_model.estimation.attitude.attitude_steps import (
    ATTITUDE,
    UNIT_TOLERANCE,
    AttitudeGateParams,
    Attitudes,
    follow_attitudes,
)
from q2q_model.geometry.rotations import identity_quat, matrix_from_quat, quat_between, vector_from_quat
from q2q_model.signals.stamps import SAME_INSTANT
from q2q_model.signals.values import Array, Mask, SwarmState

RIGHT_ANGLE = np.cos(0.25 * np.pi)
"""Last component of a quaternion that turns by a right angle."""


def measured_attitudes(state: SwarmState) -> Mask:
    """Return which vehicles of a filtered state ever had a measured attitude, (n,).

    A vehicle without is level to the last bit and has no body rate; measured attitudes have noise. Drivers
    that report a lone marker as level, in place of NaN, are so recognised, too. One that has only been upside
    down is NaN.
    """
    level = (state.quat == identity_quat(())).all(axis=1) & (state.ang_vel_body == 0.0).all(axis=1)
    return np.asarray(~level & np.isfinite(state.quat).all(axis=1))


class AttitudeTracks:
    """Attitude track of every vehicle."""

    def __init__(self, params: AttitudeGateParams, count: int) -> None:
        """Start `count` vehicles level and at rest, none of them seen."""
        self._params = params
        self._table = _unseen(0)
        self.grow(count)

    def grow(self, extra: int) -> None:
        """Add vehicles that were never seen."""
        known, self._table = self._table, _unseen(len(self._table) + extra)
        self._table[: len(known)] = known

    def keep(self, kept: Mask) -> None:
        """Forget all vehicles but some, (n,)."""
        self._table = self._table[kept]

    @property
    def _tracks(self) -> Attitudes:
        """Return the columns of the table, views of it."""
        return Attitudes(*(self._table[name] for name in Attitudes._fields))

    @property
    def table(self) -> Table:
        """Return the tracks, ATTITUDE (n,), which stay in this table until some are added or forgotten."""
        return self._table

    def set_back(self, by: float) -> None:
        """Set the times of all attitudes back by `by` [s], as the clock was."""
        self._tracks.time[:] -= by
        self._tracks.rejected_since[:] -= by

    def forget_rejected(self, t: float) -> None:
        """Count the attitudes that are rejected as rejected since t [s]."""
        tracks = self._tracks
        tracks.rejected_since[tracks.seen & np.isfinite(tracks.rejected_since)] = t

    @property
    def quat(self) -> Array:
        """Return the orientations x y z w, (n, 4); level for a vehicle never seen."""
        return self._tracks.quat.copy()

    @property
    def ang_vel_body(self) -> Array:
        """Return the body rates [rad/s], (n, 3)."""
        return self._tracks.ang_vel_body.copy()

    @property
    def never_accepted(self) -> Mask:
        """Return which vehicles have had attitudes, but none that was accepted, (n,)."""
        return np.asarray(~self._tracks.seen & np.isfinite(self._tracks.rejected_since))

    def never_upright(self, t: float) -> Mask:
        """Return which vehicles had attitudes within coast_s before t [s], but never one upright, (n,)."""
        passed = t - self._tracks.rejected_since
        return np.asarray(self.never_accepted & (passed <= self._params.coast_s + SAME_INSTANT))

    def nearest(self, offered: Array, other: Array) -> Array:
        """Return, row by row, the nearer of two quaternions (n, 4) to the track; NaN is never nearer."""
        last = self._tracks.quat
        near, far = (np.nan_to_num(np.abs(np.sum(q * last, axis=1)), nan=-1.0) for q in (offered, other))
        return np.where((near >= far)[:, None], offered, other)

    def update(self, t: float, measured: Array) -> int:
        """Take one tick's quaternions; return the number of rejected ones.

        Args:
            t: Capture time [s], later than before.
            measured: Quaternion of every vehicle, (n, 4); NaN where absent.
        """
        if follow_attitudes(t, measured, self._params, self._table):
            return 0
        return int(self._gate(t, _unit_or_nan(measured)).sum())

    def _gate(self, t: float, quat: Array) -> Mask:
        """Accept or reject each of a tick's quaternions, (n, 4); return which are rejected, (n,)."""
        tracks, params = self._tracks, self._params
        turn = quat_between(tracks.quat, quat)
        present = ~np.isnan(turn[:, 3])
        reflected = _reflections(quat, turn)
        near = tracks.seen & self._plausible(t, turn) & ~reflected
        righted = ~(tracks.seen & _is_upright(tracks.quat)) & _is_upright(quat)
        rejected = present & ~near & ~righted
        since = np.where(tracks.seen, np.minimum(tracks.rejected_since, t), t)
        tracks.rejected_since[rejected] = since[rejected]
        patience = np.where(reflected, params.flip_reacquire_s, params.reacquire_s)
        lasting = tracks.seen & (t - tracks.rejected_since >= patience - SAME_INSTANT)
        accepted = present & (near | righted | lasting)
        followed = near & (t - tracks.time <= params.coast_s + SAME_INSTANT)
        rate = self._rate(turn, np.where(followed, t - tracks.time, 1.0))
        tracks.ang_vel_body[:] = np.where(followed[:, None], rate, 0.0)
        tracks.quat[accepted] = (quat * np.copysign(1.0, turn[:, 3:]))[accepted]
        tracks.time[accepted], tracks.rejected_since[accepted] = t, np.inf
        tracks.seen[accepted] = True
        return rejected & ~accepted

    def _plausible(self, t: float, turn: Array) -> Mask:
        """Return which turns since the last accepted attitude, (n, 4), pass the gate, (n,)."""
        elapsed = np.minimum(t, self._tracks.rejected_since) - self._tracks.time
        largest = self._params.turn_max + self._params.turn_rate_max * elapsed
        return np.asarray(np.abs(turn[:, 3]) >= np.cos(0.5 * np.minimum(largest, np.pi)))

    def _rate(self, turn: Array, elapsed: Array) -> Array:
        raw, last = vector_from_quat(turn) / elapsed[:, None], self._tracks.ang_vel_body
        blend = elapsed / (elapsed + self._params.rate_filter_s)
        return np.asarray(last + blend[:, None] * (raw - last))


def _unit_or_nan(measured: Array) -> Array:
    """Return quaternions at unit length; NaN where the length is not 1 to UNIT_TOLERANCE."""
    bounded = np.where(np.abs(measured) <= 1.0 + UNIT_TOLERANCE, measured, np.nan)
    length = np.sqrt((bounded * bounded).sum(axis=1, keepdims=True))
    return np.asarray(bounded / np.where(np.abs(length - 1.0) <= UNIT_TOLERANCE, length, np.nan))


def _is_upright(quat: Array) -> Mask:
    """Return whether body z points up, row by row of (n, 4)."""
    return np.asarray(matrix_from_quat(quat)[:, 2, 2] > 0.0)


def _reflections(quat: Array, turn: Array) -> Mask:
    """Return which turns (n, 4) to quaternions (n, 4) are those of reflections.

    They are beyond a right angle and end upside down.
    """
    return np.asarray((np.abs(turn[:, 3]) < RIGHT_ANGLE) & ~_is_upright(quat))


def _unseen(count: int) -> Table:
    table = np.zeros(count, ATTITUDE)
    table["rejected_since"], table["quat"] = np.inf, identity_quat((count,))
    return table
