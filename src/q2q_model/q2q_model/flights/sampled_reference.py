"""Reference of a flight at its own samples, with rates where none were recorded.

A recording repeats a reference until the next one comes: references at 20 Hz are a staircase at ticks of
100 Hz, whose differences are no rates. Of a reference that is rarer than ticks, only a tick at which it
changes is a sample, and every tick of one that stands for HOLD_S without a velocity. Controllers that
hold their references and those that have them between the samples, too, had the same at these ticks.

Velocity and acceleration that were not recorded are those of a cubic fitted to the samples around by least
squares (Savitzky and Golay, Analytical Chemistry 1964), which late stamps disturb little:

    r(t + u) = r + r' u + r'' u^2 / 2 + r''' u^3 / 6,    |u| <= max(WIDTH, SAMPLES periods of the reference)

It does not follow a step: a sample is not sure if its fit reaches over one, or misses its samples by more
than MISFIT of their extent. A step between two samples is found if it is larger than LEAST_STEP and what the
reference moves in a tick and in the lateness of stamps together: 11 mm at 0.6 m/s in ticks of 100 Hz. Smaller
steps, steps over three samples or more, which are as motions, and steps at every other sample are not found.
"""

from dataclasses import dataclass

import numpy as np

from q2q_model.flights.flight import Flight
from q2q_model.signals.values import Array, Mask, Rows

HOLD_S = 0.3
"""Time without a change from which a reference stands [s]: no trajectory is sent as rarely."""
WIDTH = 0.15
"""Minimum half width of a fit [s]: it misses 0.2 % of a velocity at 1 Hz."""
SAMPLES = 2.0
"""Samples on each side of a fit, at least."""
MISFIT = 0.1
"""Largest misfit of a fit [-]: of a step it is 0.16 and more, of stamps late by 3 ms 0.03."""
RESOLUTION = 1e-4
"""Extent of the samples around from which there is a misfit [m]."""
SPACING = 0.005
"""Time that one sample stands for in the fits around [s]: a fit costs no more above 200 Hz."""
ROUNDING = 1e-3
"""Share of SPACING that stamps are rounded by."""
LEAST_STEP = 5e-3
"""Smallest step of a reference that stands [m]: it bends accelerations by 0.25 m/s^2; rounding to 1 mm makes
2 mm."""
LATENESS = 3.0
"""Largest deviation from the period that is a late stamp, over the median one [-]."""
BETWEEN = np.array([-1.0, 4.0, 0.0, 4.0, -1.0]) / 6.0
"""Weights of a cubic through the two before and the two after, at even distances [-]."""
DEGREE = 3
"""Degree of the fit."""
BLOCK = 1024
"""Samples that are fitted together: windows of 0.3 s take 0.5 MB for each power."""
NONE = -1
"""Row beyond the first or the last sample."""
EVERY_TICK = 1.5
"""Period below which a reference comes at every tick, and repeated ones are samples, too [ticks]."""
MOST_CHANGES = 3
"""Changes up to which references are no row of goals."""
VEL, ACC = slice(3, 6), slice(6, 9)
"""Columns of velocity and acceleration, after those of the position."""
LACKING_SHARE = 0.05
"""Share of samples without a rate from which the rate counts as fitted [-]."""
UNEVEN, UNEVEN_SHARE = 0.25, 0.1
"""Deviation from the period, and the share of steps that have it, from which samples are uneven [-]."""


@dataclass(frozen=True, slots=True)
class SampledReference:
    """Reference of all vehicles, NaN between its samples."""

    pos: Array
    """[m], world, (T, n, 3)."""
    vel: Array
    """[m/s], world, (T, n, 3)."""
    acc: Array
    """[m/s^2], world, (T, n, 3)."""
    sure: Mask
    """Samples whose rates were recorded or are those of a smooth motion, (T, n)."""
    fitted: Mask
    """Vehicles that lack velocity, and acceleration, at more than LACKING_SHARE of their samples, (n, 2)."""
    uneven: Mask
    """Vehicles whose samples are not at even distances, as their stamps are not those of the ticks, (n,)."""
    goals: Mask
    """Vehicles whose references mostly stand until the next, (n,)."""


@dataclass(frozen=True, slots=True)
class Samples:
    """Ticks with a sample of the reference of one vehicle."""

    rows: Rows
    """(k,)"""
    period: float
    """Median time between changes [s]; 0 for a reference that stands."""
    uneven: bool
    goals: bool
    """Whether most of them stand: what moves between is not in them."""


def flown_reference(flight: Flight) -> SampledReference:
    """Return the reference of all vehicles at its samples: the controller's setpoint, else the plan."""
    vel, acc = _known(flight.safe_vel, flight.ref_vel), _known(flight.safe_acc, flight.ref_acc)
    return sampled_reference(flight.t, setpoint_positions(flight), vel, acc)


def setpoint_positions(flight: Flight) -> Array:
    """Return the positions that controllers were to hold, as recorded at every tick [m], (T, n, 3)."""
    return _known(flight.safe_pos, flight.ref_pos)


def _known(setpoint: Array, plan: Array) -> Array:
    return np.where(np.isfinite(setpoint), setpoint, plan)


def sampled_reference(t: Array, pos: Array, vel: Array, acc: Array) -> SampledReference:
    """Return the reference at its samples, from what is recorded at ticks t (T,): each (T, n, 3)."""
    given = np.concatenate((pos, vel, acc), axis=2)  # (T, n, 9)
    made, sure = np.full_like(given, np.nan), np.zeros(pos.shape[:2], dtype=np.bool_)
    lacking = np.isfinite(np.tile(pos, 3)) & ~np.isfinite(given)
    lacking[..., :3] = lacking[..., 3:6]  # with a fitted velocity goes the position of the same fit
    fitted = np.zeros((pos.shape[1], 2), dtype=np.bool_)
    each = [reference_samples(t, given[:, i]) for i in range(pos.shape[1])]
    for i, found in enumerate(each):
        rows, lacks = found.rows, lacking[found.rows, i]
        made[rows, i], sure[rows, i] = given[rows, i], True
        if lacks.any():
            period = 0.0 if found.goals else found.period  # of goals it is that of cut ones, at the ends
            fits, smooth = _fits(t[rows], pos[rows, i], period, float(np.median(np.diff(t))))
            made[rows, i], sure[rows, i] = np.where(lacks, fits, given[rows, i]), smooth | ~lacks.any(axis=1)
            fitted[i] = [np.mean(lacks[:, own].any(axis=1)) > LACKING_SHARE for own in (VEL, ACC)]
    uneven = np.array([found.uneven for found in each], dtype=np.bool_)
    goals = np.array([found.goals for found in each], dtype=np.bool_)
    return SampledReference(made[..., :3], made[..., 3:6], made[..., 6:], sure, fitted, uneven, goals)


def is_rare(t: Array, given: Array) -> bool:
    """Return whether a vehicle's reference (T, columns) is rarer than ticks: its differences are no rates."""
    return bool(reference_samples(t, given).period >= EVERY_TICK * np.median(np.diff(t)))


def reference_samples(t: Array, given: Array) -> Samples:
    """Return the samples of one vehicle's reference (T, columns), whose first three are its position."""
    measured = np.isfinite(given[:, :3])
    absent = ~measured.any(axis=0)  # it may be of altitudes alone
    known = np.flatnonzero(measured.any(axis=1) & (measured | absent).all(axis=1))
    if not known.size:
        return Samples(known, 0.0, uneven=False, goals=False)
    values = np.nan_to_num(given[known])
    changed = np.append(True, (np.diff(values, axis=0) != 0.0).any(axis=1) | (np.diff(known) > 1))
    steps = np.diff(t[np.append(known[changed], known[-1])])
    goals = len(steps) > MOST_CHANGES and float(np.median(steps)) > HOLD_S
    stands = (steps > HOLD_S)[np.cumsum(changed) - 1] & (values[:, 3:] == 0.0).all(axis=1)
    moving = steps[(steps > 0.0) & (steps <= HOLD_S)]
    if not moving.size:
        return Samples(known[changed | stands], 0.0, uneven=False, goals=goals)
    period = float(np.median(moving))
    uneven = np.mean(np.abs(moving - period) > UNEVEN * period) > UNEVEN_SHARE
    every_tick = period < EVERY_TICK * np.median(np.diff(t))
    return Samples(known[changed | stands | every_tick], period, uneven=bool(uneven), goals=goals)


def _fits(t: Array, pos: Array, period: float, tick: float) -> tuple[Array, Mask]:
    """Return position, velocity and acceleration (k, 9) of a fit around each sample, and where it is smooth.

    NaN where there are too few samples around.
    """
    apart = np.flatnonzero(np.diff(np.floor((t - t[0]) / SPACING + ROUNDING), prepend=-1.0) > 0.0)
    bursts = min(HOLD_S, np.median(np.diff(t[apart], append=t[-1])))  # where ticks have any
    width = max(WIDTH, SAMPLES * max(period, float(bursts))) + 0.5 * tick
    side = int(width / max(tick, SPACING)) + 1
    every = np.arange(len(t))
    before = np.searchsorted(apart, every, side="right") - 1
    padded = np.pad(apart, side, constant_values=NONE)  # before[k] begins the window around before[k]
    blocks = [
        _fits_of(rows, padded[before[rows, None] + np.arange(2 * side + 1)], t, pos, width)
        for rows in np.split(every, range(BLOCK, len(t), BLOCK))
    ]
    made, smooth = (np.concatenate(parts) for parts in zip(*blocks, strict=True))
    return made, smooth & ~_reaching_over(_steps(t, pos, tick), t, width)


def _steps(t: Array, pos: Array, tick: float) -> Rows:
    """Return the samples after which the reference (k, 3) steps.

    Its velocity is neither the median of five nor that of a cubic through the two before and the two after:
    the former alone would be off where a velocity is largest, the latter beside another step.
    """
    if len(t) < 2:
        return np.zeros(0, dtype=np.intp)
    lasts = np.diff(t)
    vel = np.nan_to_num(np.diff(pos, axis=0)) / lasts[:, None]  # (k - 1, 3)
    around = np.stack([np.pad(vel, ((2, 2), (0, 0)), mode="edge")[i : i + len(vel)] for i in range(5)])
    usual = np.median(around, axis=0)
    off = np.minimum(np.abs(vel - usual), np.abs(vel - np.tensordot(BETWEEN, around, axes=1)))
    late = tick + LATENESS * np.median(np.abs(lasts - np.median(lasts)))
    return np.flatnonzero((off * lasts[:, None] > LEAST_STEP + np.abs(usual) * late).any(axis=1))


def _reaching_over(steps: Rows, t: Array, width: float) -> Mask:
    """Return the samples that have samples of both sides of a step within the width, (k,)."""
    later = np.searchsorted(steps, np.arange(len(t)))
    until = np.append(t[steps + 1], np.inf)[later] - t
    since = t - np.concatenate(([-np.inf], t[steps]))[later]
    return np.asarray(np.minimum(until, since) <= width)


def _fits_of(rows: Rows, around: Rows, t: Array, pos: Array, width: float) -> tuple[Array, Mask]:
    """Return the fits of rows (k,) to the rows `around` each, (k, w) or NONE, that are within the width."""
    u = (t[around] - t[rows, None]) / width
    weight = ((around != NONE) & (np.abs(u) <= 1.0)).astype(np.float64)
    powers = np.stack([weight * u**k for k in range(DEGREE + 1)], axis=-1)  # (k, w, DEGREE + 1)
    normal = np.swapaxes(powers, 1, 2) @ powers
    places = np.nan_to_num(weight[..., None] * (pos[around] - pos[rows, None]))  # (k, w, 3)
    few = weight.sum(axis=1) <= DEGREE
    normal[few] = np.eye(DEGREE + 1)
    value = np.linalg.solve(normal, np.swapaxes(powers, 1, 2) @ places)  # (k, DEGREE + 1, 3)
    value[few] = np.nan
    missed = np.sqrt(((places - powers @ value) ** 2).sum(axis=(1, 2)) / weight.sum(axis=1))
    extent = np.linalg.norm(np.ptp(places, axis=1), axis=1)
    value[np.isnan(np.broadcast_to(pos[rows, None], value.shape))] = np.nan
    made = np.concatenate(
        (pos[rows] + value[:, 0], value[:, 1] / width, 2.0 * value[:, 2] / width**2), axis=1
    )
    return made, np.asarray(missed <= MISFIT * np.maximum(extent, RESOLUTION))
