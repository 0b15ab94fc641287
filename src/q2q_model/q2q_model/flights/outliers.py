"""Detection of outliers in a recorded track, and their repair by interpolation.

Source: the paper, section 2.2: "positions and velocities greater than a threshold determined empirically
were considered outliers ... replaced by interpolating neighboring points". The causal filter
(q2q_model.estimation.mocap_filter) uses the same thresholds; this batch rule also uses later samples.

Sample k at r_k is an outlier when one of these holds:

    room       max |r_k| > pos_max, or r_k is not a number (a gap)
    repeat     r_k equals r_(k-1) to the last digit while the vehicle was moving, and the run of such samples
               ends in a forbidden step: stale frames with new stamps
    velocity   r_k is not on the chain: the largest subset of samples whose successive members i, j
               satisfy |r_j - r_i| <= jump_max + speed_max (t_j - t_i)
    position   |r_k - median of the chain's samples k-w .. k+w| > jump_max

Dynamic programming finds the chain over segments (runs without a forbidden step or a gap). A transition to a
segment out of reach costs the samples of TELEPORT: a vehicle that was carried elsewhere and stays there is
accepted, a marker swap of a few tenths of a second is not. Both times are rounded to samples of the vehicle;
from about 10 Hz down w is 0 and the rule of the position is left out, as flight itself is far from a median
then.

| symbol | name | meaning [unit] |
|---|---|---|
| r | pos | position [m], world |
| | pos_max speed_max jump_max | thresholds [m], [m/s], [m] |
| w | MEDIAN_REACH | half width of the median, in samples |
"""

from math import prod

import numpy as np
from scipy.ndimage import median_filter

from q2q_model.estimation.association.outlier_thresholds import REPEAT_STEP, OutlierThresholds
from q2q_model.flights.interpolated_gaps import resample
from q2q_model.signals.values import Array, Mask, Rows

MEDIAN_REACH = 0.05
"""Half width of the median [s]: robust to bursts of that length, 5 samples at 100 Hz."""
TELEPORT = 2.0
"""Length from which a segment out of reach is accepted [s]."""
GAP = 1.5
"""Time step from which there is a gap, and a new segment begins [median steps]."""
STEP_OVER = 10
"""Steps over which the time of one is measured: poses stamped on receipt may come several at once."""
SEGMENTS_BACK = 200
"""Number of earlier segments that the chain considers."""


def find_outliers(t: Array, pos: Array, thresholds: OutlierThresholds | None = None) -> Mask:
    """Return which samples are outliers or missing, (T, ...), of tracks pos [m] (T, ..., 3) at t [s] (T,).

    NaN samples count as outliers, for `repair` to fill. Raises ValueError for a time that does not increase.
    """
    limits = thresholds or OutlierThresholds()
    if np.any(~(np.diff(t) > 0.0)):
        row = int(np.argmax(~(np.diff(t) > 0.0)))
        raise ValueError(
            f"t must increase; {t[row + 1]} follows {t[row]}: sort them and drop repeated stamps first"
        )
    tracks = pos.reshape(len(t), prod(pos.shape[1:-1]), 3)
    found = [_outliers_of_track(t, tracks[:, column], limits) for column in range(tracks.shape[1])]
    return np.stack(found, axis=1).reshape(pos.shape[:-1]) if found else np.zeros(pos.shape[:-1], dtype=bool)


def repair(t: Array, values: Array, bad: Mask) -> Array:
    """Return `values` (T, ..., c) with rows where `bad` (T, ...) interpolated between good ones.

    Rows before the first and after the last good row take the nearest good one; a track without any good
    row is NaN.
    """
    return resample(t, np.where(bad[..., None], np.nan, values), t)


def _outliers_of_track(t: Array, pos: Array, limits: OutlierThresholds) -> Mask:
    with np.errstate(invalid="ignore"):
        inside = np.all(np.abs(pos) <= limits.pos_max, axis=-1)
    kept = np.flatnonzero(inside)
    teleport, reach = (_samples(t[kept], span) for span in (TELEPORT, MEDIAN_REACH))
    kept = kept[~_old_frames(t[kept], pos[kept], limits)]
    kept = kept[_on_chain(t[kept], pos[kept], limits, teleport)]
    kept = kept[~_off_median(t[kept], pos[kept], limits, reach)]
    bad = np.ones(len(t), dtype=bool)
    bad[kept] = False
    return bad


def _samples(t: Array, span: float) -> int:
    """Return how many samples a span of time has [s], rounded; 0 for a single one."""
    over = min(STEP_OVER, len(t) - 1)
    return round(span * over / float(np.median(t[over:] - t[:-over]))) if over > 0 else 0


def _on_chain(t: Array, pos: Array, limits: OutlierThresholds, teleport: int) -> Mask:
    starts = _segment_starts(t, pos, limits)
    if len(starts) <= 1:
        return np.ones(len(t), dtype=bool)
    ends = np.append(starts[1:], len(t)) - 1
    parent = np.full(len(starts), -1)
    best = (ends - starts + 1).astype(np.float64)
    for here in range(1, len(starts)):
        before = np.arange(max(0, here - SEGMENTS_BACK), here)
        step = np.linalg.norm(pos[starts[here]] - pos[ends[before]], axis=-1)
        reach = limits.jump_max + limits.speed_max * (t[starts[here]] - t[ends[before]])
        gain = best[before] - np.where(step <= reach, 0.0, teleport)
        choice = int(np.argmax(gain))
        if gain[choice] > 0.0:
            parent[here] = before[choice]
            best[here] += gain[choice]
    return _walk_back(parent, best, (starts, ends))


def _segment_starts(t: Array, pos: Array, limits: OutlierThresholds) -> Rows:
    step, dt = np.linalg.norm(np.diff(pos, axis=0), axis=-1), np.diff(t)
    hole = dt > GAP * np.median(dt) if len(dt) else dt > 0.0
    breaks = hole | (step > limits.speed_max * dt)
    return np.concatenate([np.zeros(min(len(t), 1), dtype=np.intp), np.flatnonzero(breaks) + 1])


def _walk_back(parent: Rows, best: Array, segments: tuple[Rows, Rows]) -> Mask:
    starts, ends = segments
    kept = np.zeros(int(ends[-1]) + 1, dtype=bool)
    here = int(np.argmax(best))
    while here >= 0:
        kept[starts[here] : ends[here] + 1] = True
        here = int(parent[here])
    return kept


def _old_frames(t: Array, pos: Array, limits: OutlierThresholds) -> Mask:
    """Return the samples of runs that repeat a pose exactly, begin in motion and end in a forbidden step."""
    step = np.linalg.norm(np.diff(pos, axis=0), axis=-1)
    same = np.append([False], step == 0.0)[: len(t)]
    run = np.cumsum(~same)
    jumps, moves = step > limits.speed_max * np.diff(t), step > REPEAT_STEP
    return same & np.isin(run, run[:-1][jumps]) & np.isin(run, run[1:][moves])


def _off_median(t: Array, pos: Array, limits: OutlierThresholds, reach: int) -> Mask:
    width = 2 * reach + 1
    if reach == 0 or len(t) < width:
        return np.zeros(len(t), dtype=bool)
    inner = slice(reach, len(t) - reach)
    centre = np.stack([median_filter(axis, width)[inner] for axis in pos.T], axis=-1)
    dense = t[width - 1 :] - t[: 1 - width] <= 2.0 * (width - 1) * np.median(np.diff(t))  # not across a gap
    off = np.zeros(len(t), dtype=bool)
    off[inner] = dense & (np.linalg.norm(pos[inner] - centre, axis=-1) > limits.jump_max)
    return off
