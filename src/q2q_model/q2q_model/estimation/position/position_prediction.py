"""Compiled prediction of the position tracks to a tick, and the samples that pass their gates.

A pose that repeats bit for bit is taken as a sample while the vehicle is slow, unless noise keeps its poses
apart (position_gates): it may be at rest. If the next one is further than THAW_STEP from the prediction, it
was an old frame under new stamps: the track restarts there with the mean velocity since the pose first came
(a thaw), else the step would count as a movement within one tick.

After a gap the gates let samples pass that are further than jump_max from the prediction. Such a sample is
doubtful: the track takes it, but is not trusted until a next one agrees.
"""

from typing import NamedTuple

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.estimation.association.jump_candidates import Table
from q2q_model.estimation.position.kalman_filter import MotionEstimate, gain, predict
from q2q_model.estimation.position.position_gates import GATE_SIGMAS, REPEATS_S, VARIED, PositionGates, screen
from q2q_model.estimation.position.track_columns import TrackColumns, TrackParams, columns_of
from q2q_model.signals.stamps import SAME_INSTANT
from q2q_model.signals.values import Array, Mask

THAW_STEP = 0.005
"""Deviation from the prediction of a sample after repeated ones that shows them to be old [m]: 5 standard
deviations of a sample; 10 m/s^2 move a vehicle by 0.5 mm within a tick."""


class Prediction(NamedTuple):
    """Tracks predicted to a tick, and the samples that pass their gates."""

    elapsed: Array
    """Time since each track's last sample [s], (n,)."""
    state: Array
    """As in kalman_filter, (n, 3, 3)."""
    cov: Array
    """(n, 3, 3)"""
    K: Array
    """Gain of a correction, (n, 3)."""
    samples: Array
    """Positions [m], (n, 3); NaN where there is no sample."""
    own: Mask
    """Tracks whose own sample passes the gates, (n,)."""
    reach: Array
    """Largest accepted distance of a sample from the prediction [m], (n,)."""
    lost: Mask
    """Tracks without a sample for longer than coast_s, (n,)."""
    repeated: Mask
    """Poses that equal a recent one bit for bit, (n,)."""
    frozen: Mask
    """Vehicles whose poses repeat though there is noise, (n,)."""
    thawed: Mask
    """Tracks whose own sample shows that the repeated ones before it were old, (n,)."""
    doubtful: Mask
    """Tracks whose own sample passes further than jump_max from the prediction, (n,)."""
    nominal: bool
    """Every track is confirmed, and its own sample passes the gates without thaw or doubt."""


@compiled(error_model="numpy")
def look_ahead(
    tick: tuple[float, float], measured: Array, repeated: Mask, params: TrackParams, table: Table
) -> Prediction:
    """Return the tracks predicted to a tick, and which samples pass their gates.

    Args:
        tick: Time [s], and the steady period of all tracks [s]; NaN without.
        measured: Positions [m], (n, 3); NaN where absent.
        repeated: Poses that equal a recent one bit for bit, (n,).
        params: Parameters.
        table: TRACK, (n,).
    """
    (t, period), tracks = tick, columns_of(table)
    elapsed = _elapsed(t, period, tracks)
    coasted, noise_var = np.minimum(elapsed, params.coast_s), params.position_noise**2
    ahead = predict(MotionEstimate(tracks.state, tracks.cov), coasted, params.jerk_noise**2)
    gates = _gates(elapsed, ahead, params, tracks)
    samples, passed, frozen = screen(measured, repeated, gates)
    own = passed & tracks.seen
    thawed = _thawed(samples, ahead.state, own & ~repeated, tracks)
    doubtful = own & _further(samples, ahead.state, params.jump_max)
    return Prediction(
        elapsed=elapsed,
        state=ahead.state,
        cov=ahead.cov,
        K=gain(ahead, noise_var),
        samples=samples,
        own=own,
        reach=np.minimum(gates.deviation, gates.reach),
        lost=gates.lost,
        repeated=repeated,
        frozen=frozen,
        thawed=thawed,
        doubtful=doubtful,
        nominal=bool((own & tracks.confirmed & ~thawed & ~doubtful).all()),
    )


@compiled
def _elapsed(t: float, period: float, tracks: TrackColumns) -> Array:
    """Return the time since each track's last sample [s], (n,): the steady period unless that is NaN."""
    elapsed = np.where(tracks.seen, t - tracks.time, 0.0)
    if not np.isnan(period):
        elapsed[:] = period
    return elapsed


@compiled
def _gates(elapsed: Array, ahead: MotionEstimate, params: TrackParams, tracks: TrackColumns) -> PositionGates:
    """Return the gates around the tracks predicted to a tick."""
    stood = np.minimum(tracks.time - tracks.since, REPEATS_S)
    return PositionGates(
        last=tracks.state[:, 0],
        moved=tracks.state[:, 1] * stood[:, None],
        expected=ahead.state[:, 0],
        reach=params.jump_max + params.speed_max * elapsed,
        deviation=params.jump_max + GATE_SIGMAS * np.sqrt(ahead.cov[:, 0, 0] + params.position_noise**2),
        lost=elapsed > params.coast_s + SAME_INSTANT,
        varies=(tracks.varied >= VARIED) & (elapsed <= params.frozen_reacquire_s + SAME_INSTANT),
        pos_max=params.pos_max,
    )


@compiled
def _thawed(samples: Array, ahead: Array, new: Mask, tracks: TrackColumns) -> Mask:
    """Return which `new` samples follow repeated ones and are further than THAW_STEP from `ahead`, (n,)."""
    return new & (tracks.time - tracks.since > SAME_INSTANT) & _further(samples, ahead, THAW_STEP)


@compiled
def _further(samples: Array, ahead: Array, distance: float) -> Mask:
    """Return which samples are further than `distance` [m] from `ahead`, (n,)."""
    further = np.zeros(len(samples), np.bool_)
    for i in range(len(samples)):
        squared = 0.0
        for k in range(3):
            squared += (samples[i, k] - ahead[i, 0, k]) ** 2
        further[i] = squared > distance * distance
    return further
