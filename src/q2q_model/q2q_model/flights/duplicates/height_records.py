"""Record of the heights of a flight, by which it is recognised at another rate, turned or mirrored.

The height of each vehicle in the air, mean over MEAN_S, is kept every 1 / RATE_HZ: noise of 1 mm becomes
0.2 mm, and neither stamps, rate, names nor the horizontal axes are in it. Two records are of one motion if
they differ, at the shift in time of least difference and less their means, by little in root mean square:

| | of copies at most | of other flights at least | bound |
|---|---|---|---|
| difference [m] | 0.0011 | 0.0040 | DIFFERENCE |
| over the standard deviation of the height [-] | 0.05 | 0.99 where the difference is below 0.006 m | SHARE |

Copies of the 34 public flights are every second or fourth row, 70 % of the rows at random, interpolated to
333 Hz or to other times, cut by a third, or with noise of 1 mm (of 3 mm they are found, too); other flights
are their 561 pairs, with repetitions of one experiment. Not found are copies that are cut to less than 10 s,
whose time is scaled, whose height is scaled or tilted, with holes of a second, or that move up and down by
less than LEAST_MOTION. A simulator that records no truth and repeats a flight but for the noise of the
positions makes copies. The shift is found to 1 / (RATE_HZ FINER) and refined to first order.
"""

from base64 import b64decode, b64encode

import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.interpolate import CubicSpline
from scipy.signal import correlate

from q2q_model.signals.values import Array

RATE_HZ, MEAN_S = 5.0, 0.4
STEP = 1e-4
"""Unit of a record [m], 16 bits: heights are within 3.2 m of their mean."""
LONGEST, SHORTEST = 3000, 50
"""Most and fewest samples of a record: 10 min, 8 kB as text, and 10 s."""
FLOOR = 0.15
"""Height up to which a vehicle may stand on the floor [m]."""
LEAST_MOTION = 0.002
"""Least standard deviation of heights to recognise a flight by [m]."""
DIFFERENCE = 0.002
"""Largest difference of the heights of one motion [m]."""
SHARE = 0.15
"""Largest share of the difference in the standard deviation of heights [-]."""
OVERLAP = 0.5
"""Least share of the shorter record that the two have in common [-]."""
FINER = 8
"""Shifts in time for one sample."""

Heights = tuple[Array, ...]
"""Heights of every vehicle that moves up and down [m]."""


def height_records(t: Array, pos: Array) -> Heights:
    """Return the records of positions (T, n, 3) [m] at times (T,) [s]; NaN where a vehicle is not seen."""
    found = []
    for i in range(pos.shape[1]):
        seen = np.isfinite(pos[:, i]).all(axis=1)
        found.append(_record(*_in_the_air(t[seen], pos[seen, i, 2])))
    return tuple(one for one in found if one.size >= SHORTEST and one.std() >= LEAST_MOTION)


def hold_same_heights(one: Heights, other: Heights) -> bool:
    """Return whether every vehicle of one of two flights moves as one of the other."""
    if not one or not other:
        return False
    part, whole = sorted((one, other), key=len)
    return all(any(_same_motion(own, there) for there in whole) for own in part)


def heights_as_text(heights: Heights) -> str:
    """Return records as text."""
    return ",".join(b64encode(np.rint(one / STEP).astype("<i2").tobytes()).decode() for one in heights)


def heights_from_text(text: str) -> Heights:
    """Return the records of `heights_as_text`; none if the text is not such."""
    try:
        packed = [b64decode(one, validate=True) for one in text.split(",") if one]
        return tuple(STEP * np.frombuffer(one, dtype="<i2") for one in packed)
    except ValueError:
        return ()


def _in_the_air(t: Array, height: Array) -> tuple[Array, Array]:
    """Return times and heights from the first to the last one above FLOOR: at rest all flights are alike."""
    up = np.flatnonzero(height > FLOOR)
    flown = slice(up[0], up[-1] + 1) if up.size else slice(0)
    return t[flown], height[flown]


def _record(t: Array, height: Array) -> Array:
    """Return the record of one vehicle's heights (T,), less their mean."""
    count = int((t[-1] - t[0] - MEAN_S) * RATE_HZ) if t.size > 1 else 0
    if count < SHORTEST:
        return np.empty(0)
    ends = t[0] + MEAN_S * np.arange(2)[:, None] + np.arange(min(count, LONGEST)) / RATE_HZ
    before, after = np.interp(ends, t, cumulative_trapezoid(height, t, initial=0.0))
    means = (after - before) / MEAN_S
    return np.asarray(STEP * np.clip(np.rint((means - means.mean()) / STEP), -32767, 32767))


def _same_motion(one: Array, other: Array) -> bool:
    """Return whether two records are of one motion."""
    part, whole = sorted((_finer(one), _finer(other)), key=len)
    lag = _best_lag(whole, part)
    common = slice(max(0, -lag), min(part.size, whole.size - lag))
    own, there = part[common], whole[common.start + lag : common.stop + lag]
    own, there = own - own.mean(), there - there.mean()
    slope = np.gradient(own) - np.gradient(own).mean()
    rest = there - own
    rest = rest - slope * (slope @ rest) / max(float(slope @ slope), np.finfo(float).tiny)
    difference = float(rest.std())
    return bool(difference < min(DIFFERENCE, SHARE * float(min(own.std(), there.std()))))


def _best_lag(whole: Array, part: Array) -> int:
    """Return the lag of least difference: part[k] is at whole[k + lag]."""
    ones, others = np.ones(whole.size), np.ones(part.size)
    count = np.maximum(np.rint(correlate(ones, others, method="fft")), 1.0)
    sums = [correlate(whole, others, method="fft"), correlate(ones, part, method="fft")]
    squares = correlate(whole**2, others, method="fft") + correlate(ones, part**2, method="fft")
    mean = (sums[0] - sums[1]) / count
    square = (squares - 2.0 * correlate(whole, part, method="fft")) / count - mean**2
    allowed = count >= OVERLAP * part.size
    return int(np.argmin(np.where(allowed, square, np.inf))) - (part.size - 1)


def _finer(record: Array) -> Array:
    """Return a record with FINER samples for each step, by a cubic spline."""
    at = np.arange(record.size)
    return np.asarray(CubicSpline(at, record)(np.arange(0.0, record.size - 1.0, 1.0 / FINER)))
