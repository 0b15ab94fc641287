"""Residual of an interaction model, predicted from its own past.

The residual r = y - eta stays correlated for about 0.1 s. What is known of it at t - h improves the
prediction for t:

    y^(t) = eta(t) + rho r(t - h),    rho = (P rho_0 + sum r(s) r(s - h)) / (P + sum r(s - h)^2),  s <= t - h

rho, between 0 and 1, is estimated from the flight itself up to t - h. It begins at rho_0, that of the
residual of real flights (q2q_model.downwash.correction.residual_process), with the weight of some 100 rows.
eta(t) is that of the positions at t: positions extrapolated over 20 ms differ from them by less than a
millimetre.
"""

import numpy as np

from q2q_model.downwash.correction.residual_process import REAL_FLIGHTS
from q2q_model.signals.stamps import SAME_STAMP
from q2q_model.signals.values import Array, Mask

HORIZON_S = 0.02
"""h [s]: from a measurement to the effect of the command that uses it, at best."""
PRIOR = 20.0
"""P [m^2/s^4]: 1 s of residuals of 0.45 m/s^2 at 100 Hz, the rms of real flights."""


def predicted_residual(t: Array, residual: Array, usable: Mask) -> Array:
    """Return rho r(t - h) [m/s^2], (T,); 0 where no row h before, or up to one period more, is usable.

    Args:
        t: Rising times [s], (T,).
        residual: r [m/s^2], (T,).
        usable: Rows in which r is known, (T,).
    """
    before = np.searchsorted(t, t - HORIZON_S + SAME_STAMP) - 1
    oldest = t - HORIZON_S - np.median(np.diff(t)) - SAME_STAMP
    known = usable & (before >= 0) & usable[before] & (t[before] >= oldest)
    past = np.where(known, residual[before], 0.0)
    products = np.cumsum(np.where(known, residual, 0.0) * past)
    squares = np.cumsum(past * past)
    num, den = (np.where(before >= 0, sums[before], 0.0) for sums in (products, squares))
    rho = (PRIOR * REAL_FLIGHTS.correlation(HORIZON_S) + num) / (PRIOR + den)
    return np.asarray(np.clip(rho, 0.0, 1.0) * past)
