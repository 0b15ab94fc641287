"""Compiled steps of the position tracks: take samples that are assigned to them, or all of a nominal tick.

A tick is nominal if every track is confirmed and the sample of its own name passes its gates without thaw or
doubt (position_prediction). It has gaps if some vehicles have no sample, and that holds for all others. In
other ticks the samples need association (position_tracks).
"""

import math
from typing import NamedTuple

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.estimation.association.jump_candidates import Table
from q2q_model.estimation.position.kalman_filter import MotionEstimate, correct
from q2q_model.estimation.position.position_gates import count_varied
from q2q_model.estimation.position.position_prediction import Prediction, look_ahead
from q2q_model.estimation.position.steady_gain import LAST, PERIOD, is_due, steady_period
from q2q_model.estimation.position.track_columns import TrackParams, columns_of
from q2q_model.signals.values import Array, Mask, Rows

NEEDS_ASSOCIATION, WITH_GAPS, WHOLE = 0, 1, 2
"""Outcomes of `follow_positions`: no track has changed; the tick has gaps; it is nominal."""


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


@compiled
def accept(
    t: float, at: Prediction, assigned: Association, noise_var: float, table: Table
) -> tuple[Array, Array]:
    """Take the samples assigned at t [s] into the tracks; return pos [m] and vel [m/s], world, (n, 3) each.

    `noise_var` is the variance of a sample per axis [m^2]; `table` is TRACK, (n,).
    """
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
            tracks.refuted[i] = refuted
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
