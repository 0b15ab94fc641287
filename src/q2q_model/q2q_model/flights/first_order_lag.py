"""First-order lag of recorded values, as of thrust behind its command."""

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.flights.interpolated_gaps import interpolate_gaps
from q2q_model.signals.values import Array


def first_order_lag(values: Array, t: Array, lag: float) -> Array:
    """Return values (T, n) after a first-order lag [s]; missing ones (NaN) are interpolated first."""
    known = interpolate_gaps(t, values)
    if lag <= 0.0:
        return known
    keep = np.exp(-np.diff(t) / lag)
    return _first_order(np.ascontiguousarray(known), keep)


@compiled
def _first_order(values: Array, keep: Array) -> Array:
    """Return y_k = keep_k y_(k-1) + (1 - keep_k) values_k, (T, n), beginning settled; keep is (T - 1,)."""
    out = values.copy()
    for k in range(1, values.shape[0]):
        out[k] = keep[k - 1] * out[k - 1] + (1.0 - keep[k - 1]) * values[k]
    return out
