"""Gaps of recorded values, interpolated."""

import numpy as np

from q2q_model.signals.values import Array


def interpolate_gaps(t: Array, values: Array) -> Array:
    """Return values (T, ...) with missing ones (NaN) interpolated over times t [s], (T,); 0 if all are."""
    columns = values.reshape(t.size, -1).copy()
    for column in columns.T:
        good = np.isfinite(column)
        if good.any():
            column[~good] = np.interp(t[~good], t[good], column[good])
        else:
            column[:] = 0.0
    return columns.reshape(values.shape)
