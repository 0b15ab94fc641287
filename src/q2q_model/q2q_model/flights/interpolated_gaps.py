"""Recorded values between their rows and over their gaps: interpolated, or those of the nearest row."""

import numpy as np

from q2q_model.signals.values import Array, Rows


def interpolate_gaps(t: Array, values: Array) -> Array:
    """Return values (T, ...) with missing ones (NaN) interpolated; 0 if all are. Times t [s], (T,), rise."""
    return np.nan_to_num(resample(t, values, t))


def resample(t: Array, values: Array, at: Array) -> Array:
    """Return `values` (T, ...) of rising times interpolated between finite rows; NaN if none is finite."""
    columns = values.reshape(t.size, -1)
    out = np.empty((at.size, columns.shape[1]))
    for k, column in enumerate(columns.T):
        good = np.isfinite(column)
        out[:, k] = np.interp(at, t[good], column[good]) if good.any() else np.nan
    return out.reshape(at.size, *values.shape[1:])


def nearest_samples(t: Array, at: Array) -> Rows:
    """Return, for each time of `at` (k,), the row of the nearest of rising times t (m,).

    Of two that are equally near, it is the earlier.
    """
    right = np.clip(np.searchsorted(t, at), 0, len(t) - 1)
    left = np.clip(right - 1, 0, None)
    return np.where(np.abs(t[left] - at) <= np.abs(t[right] - at), left, right)
