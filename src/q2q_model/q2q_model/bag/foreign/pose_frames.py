"""Frames from the poses of vehicles, each with stamps of its own.

The ticks are the stamps of the vehicle with the most poses and, where that one is not seen, those of the
vehicle with the next most. A tick takes the pose of each vehicle nearest in time within a tolerance; no tick
takes a pose that is nearer to another. Of poses with the same stamp, the last that was recorded counts.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from q2q_model.counted import counted
from q2q_model.flights.interpolated_gaps import nearest_samples
from q2q_model.signals.clock_resets import CONFIRM_STAMPS, SET_BACK_S
from q2q_model.signals.values import Array, Mask, MocapFrame, Rows

HOLE_PERIODS = 0.75
"""Distance from the nearest tick from which a pose makes a tick of its own, and an old stamp is in a hole
[median periods]; half a period is that of a vehicle captured between the ticks."""


@dataclass(frozen=True, slots=True)
class Poses:
    """Poses of one vehicle in the order of their stamps, those of one stamp as recorded."""

    t: Array
    """(rows,) [s]."""
    pos: Array
    """(rows, 3) [m], world."""
    quat: Array
    """(rows, 4), xyzw."""
    back: float
    """Most that a stamp lies before one recorded earlier [s]."""


def pose_frames(tracks: Mapping[str, Poses], tolerance_s: float) -> tuple[list[MocapFrame], list[str]]:
    """Return one frame per tick with every pose within the tolerance, and remarks on poses left out.

    Raises:
        ValueError: the poses of a vehicle match no pose of the one with the most.
    """
    once = {vehicle: _once_a_stamp(track) for vehicle, track in tracks.items()}
    ticks, repairs = _ticks(once, tolerance_s), []
    rows = {}
    for vehicle, track in once.items():
        rows[vehicle] = nearest_rows(ticks, track.t, tolerance_s)
        lost = len(track.t) - np.count_nonzero(rows[vehicle] >= 0)
        if track.back > 0.0:
            repairs.append(
                f"stamps of poses of {vehicle} go back by up to {track.back:.3f} s: sorted by time"
            )
        if repeated := len(tracks[vehicle].t) - len(track.t):
            repairs.append(f"{counted(repeated, 'repeated stamp')} of poses of {vehicle}: the last is used")
        if lost:
            repairs.append(f"{lost} of {len(track.t)} poses of {vehicle} match no tick: dropped")
    return [_frame(float(t), once, rows, tick) for tick, t in enumerate(ticks)], repairs


def _once_a_stamp(track: Poses) -> Poses:
    """Return the last pose of every stamp."""
    last = np.append(np.diff(track.t) > 0.0, True)
    return Poses(track.t[last], track.pos[last], track.quat[last], track.back)


def _frame(t: float, tracks: Mapping[str, Poses], rows: Mapping[str, Rows], tick: int) -> MocapFrame:
    near = [(vehicle, row[tick]) for vehicle, row in rows.items() if row[tick] >= 0]
    pos = np.array([tracks[vehicle].pos[row] for vehicle, row in near]).reshape(-1, 3)
    quat = np.array([tracks[vehicle].quat[row] for vehicle, row in near]).reshape(-1, 4)
    return MocapFrame(t=t, names=tuple(vehicle for vehicle, _ in near), pos=pos, quat=quat)


def _ticks(tracks: Mapping[str, Poses], tolerance_s: float) -> Array:
    fullest, *others = sorted(tracks.items(), key=lambda item: -len(item[1].t))
    ticks = np.unique(fullest[1].t)
    hole_s = HOLE_PERIODS * float(np.median(np.diff(ticks))) if len(ticks) > 1 else 0.0
    for vehicle, track in others:
        away = np.abs(track.t - ticks[nearest_samples(ticks, track.t)])
        if (away > tolerance_s).all():
            raise ValueError(_unmatched(vehicle, track.t, ticks, tolerance_s))
        ticks = np.union1d(ticks, track.t[away > max(hole_s, tolerance_s)])
    return ticks


def _unmatched(vehicle: str, t: Array, ticks: Array, tolerance_s: float) -> str:
    """Return why no pose of a vehicle is in a frame."""
    if misfit := clock_mismatch(f"poses of {vehicle}", t, ticks):
        return misfit
    period_s = float(np.median(np.diff(ticks)))
    return (
        f"no pose of {vehicle} was captured within tolerance_s = {tolerance_s:g} s of a frame: raise it "
        f"in the topic map to half the period of {period_s:.3f} s"
    )


def clock_mismatch(what: str, t: Array, ticks: Array, before_s: float = 0.0) -> str:
    """Return why ascending stamps t (m,) [s] are of other times than ticks (T,) [s]; empty if they are not.

    They may end up to `before_s` [s] before the first tick.
    """
    if t[0] <= ticks[-1] and ticks[0] - before_s <= t[-1]:
        return ""
    spans = f"{t[0]:.3f} to {t[-1]:.3f} s, not {ticks[0]:.3f} to {ticks[-1]:.3f} s"
    return f"{what} lie at {spans}: the clocks differ, or the recordings do not overlap"


def clock_set_back(t: Array) -> str:
    """Return where the clock of stamps (m,) [s] in recorded order was set back; empty if it was not.

    Some stamps in a row are then older by more than SET_BACK_S than as many in a row before, and among the
    others; fewer are late or wrong, and of those that fill a hole of the others sorting is the order.
    """
    if len(t) < 2 * CONFIRM_STAMPS:
        return ""
    in_a_row = sliding_window_view(t, CONFIRM_STAMPS)
    reached = np.maximum.accumulate(in_a_row.min(axis=1))[:-CONFIRM_STAMPS]
    old = np.flatnonzero(reached - in_a_row.max(axis=1)[CONFIRM_STAMPS:] > SET_BACK_S) + CONFIRM_STAMPS
    doubled = old[_are_among(t, old[:, None] + np.arange(CONFIRM_STAMPS)).all(axis=1)]
    if not len(doubled):
        return ""
    before = old[old <= doubled[0]]
    row = before[np.append(True, np.diff(before) > 1)][-1]
    steps = f"after {row} of {len(t)}, their stamps go back from {t[row - 1]:.3f} to {t[row]:.3f} s"
    return f"{steps}: the clock was set back, which would mix two flights; split the bag there"


def _are_among(t: Array, rows: Rows) -> Mask:
    """Return which of some rows (k, w) of stamps are nearer to others than these follow each other."""
    if not rows.size:
        return np.zeros(rows.shape, dtype=np.bool_)
    others, steps = np.sort(np.delete(t, np.unique(rows))), np.diff(t[: rows.min()])
    period = float(np.median(steps[steps > 0.0])) if (steps > 0.0).any() else 0.0
    return np.asarray(np.abs(t[rows] - others[nearest_samples(others, t[rows])]) < HOLE_PERIODS * period)


def nearest_rows(ticks: Array, t: Array, tolerance_s: float) -> Rows:
    """Return for each tick the nearest row of ascending `t`, (len(ticks),); -1 if none is in tolerance.

    A row that is the nearest of several ticks is given to the nearest of these: repeated at the others, it
    would be a vehicle that stands and leaps.
    """
    nearest = nearest_samples(t, ticks)
    away = np.abs(t[nearest] - ticks)
    order = np.lexsort((away, nearest))
    first = order[np.unique(nearest[order], return_index=True)[1]]
    once = np.isin(np.arange(len(ticks)), first)
    return np.where(once & (away <= tolerance_s), nearest, -1)
