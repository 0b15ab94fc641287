"""Track attitudes and body rates through reflections that turn a rigid body over.

A quaternion q, tau after the last one taken q0, is taken when its angle to q0 is at most
turn_max + turn_rate_max tau, where tau does not grow while samples are refused; what is refused but lasts
`reacquire_s` is believed. q and -q are one attitude:
the sign nearest the last is kept. The body rate is the constant one between successive attitudes, behind a
first-order low pass, so it lags by half a sample and the filter's time constant T:

    w_raw = log(q0* q) / tau,   w = w + tau / (tau + T) (w_raw - w)

In a dropout the attitude is held and the rate is zero.

| symbol | name | meaning [unit] |
|---|---|---|
| q | quat | orientation x y z w, body to world |
| w | ang_vel_body | body rate [rad/s] |
| T | rate_filter_s | time constant of the rate [s]; 0 is none |
"""

import math
from dataclasses import dataclass

import numpy as np

from q2q_model.estimation.partial_frame import turn_present
from q2q_model.estimation.reacquisition import SAME_INSTANT
from q2q_model.estimation.track_rows import padded
from q2q_model.estimation.usual_frame import UNIT_TOLERANCE, glide_attitudes
from q2q_model.flights.outliers import Mask
from q2q_model.geometry.rotations import identity_quat, quat_between, vector_from_quat
from q2q_model.signals.values import Array


@dataclass(frozen=True, slots=True)
class AttitudeGateParams:
    """Filter parameters that AttitudeTracks needs."""

    turn_max: float
    """[rad]"""
    turn_rate_max: float
    """[rad/s]"""
    rate_filter_s: float
    reacquire_s: float
    coast_s: float


class AttitudeTracks:
    """Attitude track of every vehicle."""

    def __init__(self, params: AttitudeGateParams, count: int) -> None:
        """Start `count` vehicles level and at rest, none of them seen."""
        self._params = params
        self._seen: Mask = np.zeros(count, dtype=bool)
        self._time: Array = np.zeros(count)
        self._refused_since: Array = np.full(count, np.inf)
        self._whole_at: float | None = None  # the last tick, if every vehicle's sample was taken
        self._turn = np.empty(4)
        self.quat: Array = identity_quat((count,))
        """Orientation x y z w, (n, 4); level for a vehicle never seen."""
        self.ang_vel_body: Array = np.zeros((count, 3))
        """Body rate [rad/s], (n, 3)."""

    def grow(self, extra: int) -> None:
        """Add vehicles that were never seen."""
        self._settle()
        self._seen, self._time = padded(self._seen, extra), padded(self._time, extra)
        self._refused_since = np.append(self._refused_since, np.full(extra, np.inf))
        self.quat = np.concatenate([self.quat, identity_quat((extra,))])
        self.ang_vel_body = padded(self.ang_vel_body, extra)

    def nearest(self, offered: Array, other: Array) -> Array:
        """Return, row by row, which of two quaternions (n, 4) is nearer the track; NaN is never nearer."""
        near, far = (np.nan_to_num(np.abs(np.sum(q * self.quat, axis=1)), nan=-1.0) for q in (offered, other))
        return np.where((near >= far)[:, None], offered, other)

    def update(self, t: float, pose: Array) -> int:
        """Take one tick's quaternions; return how many were there but refused.

        Args:
            t: Capture time [s], later than before.
            pose: Position and quaternion of every vehicle, (n, 7); NaN where absent.
        """
        if self._glide(t, pose) or self._without_absent(t, pose):
            return 0
        measured = np.where(np.abs(pose[:, 3:]) <= 1.0 + UNIT_TOLERANCE, pose[:, 3:], np.nan)
        length = np.sqrt((measured * measured).sum(axis=1))
        length = np.where(np.abs(length - 1.0) <= UNIT_TOLERANCE, length, np.nan)
        quat = measured / length[:, None]
        turn = quat_between(self.quat, quat)
        quat *= np.copysign(1.0, turn[:, 3:])
        return int(self._sort_out(t, quat, turn).sum())

    def _glide(self, t: float, pose: Array) -> bool:
        """Take a whole tick after a whole tick, where nothing is unusual; else return False."""
        if self._whole_at is None or t - self._whole_at > self._params.coast_s:
            return False
        elapsed = t - self._whole_at
        believable = self._params.turn_max + self._params.turn_rate_max * elapsed
        blend = elapsed / (elapsed + self._params.rate_filter_s)
        turning = elapsed, math.cos(0.5 * min(believable, math.pi)), blend
        if not glide_attitudes(pose, self.quat, self.ang_vel_body, turning, self._turn):
            return False
        self._whole_at = t
        return True

    def _without_absent(self, t: float, pose: Array) -> bool:
        """Take a tick in which some are absent and nothing else is unusual; else return False."""
        self._settle()
        if not self._seen.all() or np.isfinite(self._refused_since).any():
            return False
        params = self._params
        turning = (params.turn_max, params.turn_rate_max, params.rate_filter_s, params.coast_s)
        if not turn_present(pose, (self.quat, self.ang_vel_body), t - self._time, turning):
            return False
        taken = ~np.isnan(pose[:, 3:]).any(axis=1)
        self._time[taken] = t
        self._whole_at = t if taken.all() else None
        return True

    def _settle(self) -> None:
        """Write down, vehicle by vehicle, what `_glide` left aside."""
        if self._whole_at is not None:
            self._time[:], self._refused_since[:], self._whole_at = self._whole_at, np.inf, None

    def _rate(self, turn: Array, elapsed: Array) -> Array:
        raw = vector_from_quat(turn) / elapsed[:, None]
        blend = elapsed / (elapsed + self._params.rate_filter_s)
        return self.ang_vel_body + blend[:, None] * (raw - self.ang_vel_body)

    def _sort_out(self, t: float, quat: Array, turn: Array) -> Mask:
        self._settle()
        elapsed = np.minimum(t, self._refused_since) - self._time
        believable = self._params.turn_max + self._params.turn_rate_max * elapsed
        near = self._seen & (np.abs(turn[:, 3]) >= np.cos(0.5 * np.minimum(believable, np.pi)))
        stale = t - self._time > self._params.coast_s + SAME_INSTANT
        whole = ~np.isnan(quat[:, 3])
        refused = whole & ~near & self._seen
        self._refused_since = np.where(refused, np.minimum(self._refused_since, t), self._refused_since)
        lasting = t - self._refused_since >= self._params.reacquire_s - SAME_INSTANT
        fresh = whole & (~self._seen | (refused & lasting) | (near & stale))
        taken = near | fresh
        followed = taken & ~fresh
        rate = self._rate(turn, np.where(followed, t - self._time, 1.0))
        self.ang_vel_body = np.where(followed[:, None], rate, 0.0)
        self.quat = np.where(taken[:, None], quat, self.quat)
        self._time = np.where(taken, t, self._time)
        self._refused_since = np.where(taken, np.inf, self._refused_since)
        self._seen |= taken
        self._whole_at = t if taken.all() else None
        return refused & ~fresh
