"""Quantities on an even grid of times: interpolated between ticks, and missing where the nearest tick is."""

import numpy as np

from q2q_model.flights.interpolated_gaps import nearest_samples, resample
from q2q_model.geometry.rotations import continuous_quats, normalised
from q2q_model.signals.values import Array

MOST_SAMPLES = 1_000_000
"""Most samples of a run: five and a half hours at the highest rate."""
HOLE_S = 0.05
"""Distance from the nearest recorded tick beyond which a sample is missing [s]."""


def even_times(t: Array, rate: float) -> Array:
    """Return times (m,) at an even rate [Hz] over stamps t (T,) [s].

    Raises:
        ValueError: the stamps span more than `MOST_SAMPLES`, as by a clock that was set.
    """
    if (span := float(t[-1] - t[0])) * rate > MOST_SAMPLES:
        at = int(np.argmax(np.diff(t)))
        raise ValueError(
            f"the stamps span {span:.6g} s, with a gap of {t[at + 1] - t[at]:.6g} s after {t[at]:.6g} s; "
            f"must be at most {MOST_SAMPLES / rate:.6g} s: replay a part (replay_page --start, --end)"
        )
    count = int(span * rate + 1e-6) + 1  # the last stamp too, if rounded
    return np.asarray(t[0] + np.arange(count) / rate)


def even_samples(t: Array, values: Array, at: Array) -> Array:
    """Return values (T, ...) of stamps t at even times `at`; NaN without a value at the nearest tick."""
    nearest = nearest_samples(t, at)
    samples = resample(t, values, at)
    samples[~np.isfinite(values[nearest])] = np.nan
    samples[np.abs(t[nearest] - at) > max(HOLE_S, _period(at))] = np.nan
    return samples


def even_quats(t: Array, quat: Array, at: Array) -> Array:
    """Return quaternions (T, n, 4), interpolated the short way, w >= 0; NaN as of `even_samples`."""
    alike = quat.copy()
    for vehicle in range(quat.shape[1]):
        known = np.isfinite(quat[:, vehicle]).all(axis=1)
        alike[known, vehicle] = continuous_quats(quat[known, vehicle])
    samples = normalised(even_samples(t, alike, at))
    return np.where(samples[..., 3:] < 0.0, -samples, samples)


def _period(at: Array) -> float:
    return float(at[1] - at[0]) if len(at) > 1 else 0.0
