"""Compiled steps of the position tracks: predict and gate, take samples, do both in a nominal tick.

A tick is nominal if every track is confirmed and the sample of its own name passes its gates without thaw or
doubt. It has gaps if some vehicles have no sample, and that holds for all others. In other ticks the samples
need association (position_tracks).

A pose that repeats bit for bit is taken as a sample while the vehicle is slow, unless noise keeps its poses
apart (position_gates): it may be at rest. If the next one is further than THAW_STEP from the prediction, it
was an old frame under new stamps: the track restarts there with the mean velocity since the pose first came
(a thaw), else the step would count as a movement within one tick.

After a gap the gates let samples pass that are further than jump_max from the prediction. Such a sample is
doubtful: the track takes it, but is not trusted until a next one agrees.
"""

import math
from typing import NamedTuple

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.estimation.association.jump_candidates import SAME_INSTANT, Table
from q2q_model.estimation.position.kalman_filter import MotionEstimate, correct, gain, predict
from q2q_model.estimation.position.position_gates import (
    GATE_SIGMAS,
    REPEATS_S,
    VARIED,
    PositionGates,
    count_varied,
    screen,
)
from q2q_model.estimation.position.steady_gain import LAST, PERIOD, is_due, steady_period
from q2q_model.estimation.position.track_columns import TrackColumns, TrackParams, columns_of
from q2q_model.signals.values import Array, Mask, Rows

THAW_STEP = 0.005
"""Deviation from the prediction of a sample after repeated ones that shows them to be old [m]: 5 standard
deviations of a sample; 10 m/s^2 move a vehicle by 0.5 mm within a tick."""
NEEDS_ASSOCIATION, WITH_GAPS, WHOLE = 0, 1, 2
"""Outcomes of `follow_positions`: no track has changed; the tick has gaps; it is nominal."""


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
    """Largest believable distance of a sample from the prediction [m], (n,)."""
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


class Association(NamedTuple):
    """Samples assigned to tracks."""

    source: Rows
    """As TrackUpdate.source."""
    began: Mask
    """Tracks that start, or restart after an unconfirmed first sample, (n,)."""
    jumped: Mask
    """Tracks that restart at a true jump or a thaw, (n,)."""


class Offered(NamedTuple):
    """Samples of a tick."""

    measured: Array
    """Positions [m], (n, 3); NaN where absent."""
    repeated: Mask
    """Poses that equal a recent one bit for bit, (n,)."""
    fresh: bool
    """No vehicle's x repeats the last frame."""


class TrackMemory(NamedTuple):
    """What position tracks keep from tick to tick, for one kernel of nominal ticks."""

    tracks: Table
    """TRACK, (n,)."""
    candidates: Table
    """CANDIDATE of q2q_model.estimation.association.jump_candidates, (n,)."""
    clock: Array
    """Of q2q_model.estimation.position.steady_gain, (2,)."""


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
        varies=(tracks.varied >= VARIED) & (elapsed <= params.frozen_s + SAME_INSTANT),
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


@compiled
def accept(
    t: float, at: Prediction, assigned: Association, noise_var: float, table: Table
) -> tuple[Array, Array]:
    """Take the assigned samples into the tracks; return positions and velocities, (n, 3) each."""
    tracks = columns_of(table)
    better = correct(MotionEstimate(at.state, at.cov), at.samples[assigned.source], at.K, noise_var)
    pos, vel = np.empty_like(at.samples), np.zeros_like(at.samples)
    for i, source in enumerate(assigned.source):
        if source < 0:
            pos[i] = at.state[i, 0]
            if not at.lost[i]:
                vel[i] = at.state[i, 1]
            continue
        refuted = assigned.began[i] and tracks.seen[i]
        tracks.seen[i], tracks.time[i] = True, t
        if not at.repeated[source]:
            tracks.since[i] = t
        if assigned.began[i] or assigned.jumped[i]:
            tracks.own[i], tracks.confirmed[i] = 0 if refuted else 1, assigned.jumped[i]
        else:
            tracks.state[i], tracks.cov[i] = better.state[i], better.cov[i]
            if source == i:
                tracks.own[i] += 1
                tracks.borrowed[i], tracks.confirmed[i] = 0, tracks.own[i] > 1
            else:
                tracks.borrowed[i] += 1
        count_varied(tracks, i, (at.samples[source], at.state[i, 0]), at.repeated[source])
        pos[i], vel[i] = tracks.state[i, 0], tracks.state[i, 1]
    return pos, vel


@compiled
def follow_positions(
    t: float,
    offered: Offered,
    params: TrackParams,
    memory: TrackMemory,
    out: tuple[Array, Array],
) -> int:
    """Take the samples of a tick in which each is accepted by the track of its own name; return the outcome.

    Args:
        t: Time [s].
        offered: Samples.
        params: Parameters.
        memory: Of the tracks.
        out: Written unless NEEDS_ASSOCIATION: positions and velocities, (n, 3) each.
    """
    (measured, repeated, fresh), table, clock = offered, memory.tracks, memory.clock
    steady = is_due(clock, t)
    at = look_ahead((t, clock[PERIOD] if steady else math.nan), measured, repeated, params, table)
    if steady and not at.nominal:
        steady = False
        at = look_ahead((t, math.nan), measured, repeated, params, table)
    if not (at.nominal or _only_gaps(at, measured, table)):
        return NEEDS_ASSOCIATION
    K = table["gain"].copy() if steady else at.K
    better = correct(MotionEstimate(at.state, at.cov), at.samples, K, params.position_noise**2)
    if not steady:
        converged = at.nominal and fresh
        clock[PERIOD] = steady_period(at.elapsed, table["cov"], better.cov) if converged else math.nan
        table["gain"][:] = at.K
    clock[LAST] = t
    _take_own((t, steady), at, better, memory, out)
    return WHOLE if at.nominal else WITH_GAPS


@compiled
def _only_gaps(at: Prediction, measured: Array, table: Table) -> bool:
    """Return whether all samples that there are pass, and are of confirmed tracks."""
    for i in range(len(at.own)):
        absent = math.isnan(measured[i, 0]) or math.isnan(measured[i, 1]) or math.isnan(measured[i, 2])
        fits = at.own[i] and table["confirmed"][i] and not (at.thawed[i] or at.doubtful[i])
        if not (absent or fits):
            return False
    return True


@compiled
def _take_own(
    tick: tuple[float, bool],
    at: Prediction,
    better: MotionEstimate,
    memory: TrackMemory,
    out: tuple[Array, Array],
) -> None:
    """Take corrected states of tracks with a sample.

    `tick` is the time [s], and whether covariances stand still; the rest is as above.
    """
    (t, steady), tracks, (pos, vel) = tick, columns_of(memory.tracks), out
    for i in range(len(at.own)):
        if not at.own[i]:
            pos[i], vel[i] = at.state[i, 0], 0.0
            if not at.lost[i]:
                vel[i] = at.state[i, 1]
            continue
        tracks.seen[i], tracks.confirmed[i], tracks.time[i] = True, True, t
        if not at.repeated[i]:
            tracks.since[i] = t
        tracks.own[i] += 1
        tracks.borrowed[i] = 0
        tracks.state[i] = better.state[i]
        if not steady:
            tracks.cov[i] = better.cov[i]
        count_varied(tracks, i, (at.samples[i], at.state[i, 0]), at.repeated[i])
        pos[i], vel[i] = better.state[i, 0], better.state[i, 1]
        memory.candidates["samples"][i] = 0
        memory.candidates["ambiguous"][i] = False
