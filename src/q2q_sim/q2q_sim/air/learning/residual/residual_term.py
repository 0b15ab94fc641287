"""Vertical turbulence under a wake: an Ornstein-Uhlenbeck process whose size grows with the mean downwash.

    E e(t) e(t + l) = s(t) s(t + l) exp(-l / T) + C(l),   s = floor min(|eta| / e_0, 1) + slope |eta|

e = y - g eta is what jet and absorption leave of y on exposed rows, g the gain of the vehicle in its flight,
C its autocovariance in the clear air of the same vehicle's flight (of all flights where that has none). Sums
of products by lag and |eta| are fitted by least squares, each weighted by its rows and by the variance of its
level of |eta|. eta is that of a jet from other flights (leave_one_group_out). The gains of vehicles and
flights differ by more than their errors; their standard deviation is part of the term.
"""

from collections.abc import Sequence

import numpy as np
from scipy.optimize import least_squares

from q2q_model.signals.values import Array
from q2q_sim.air.air_terms import INSIDE, AbsorptionTerm, ResidualTerm
from q2q_sim.air.learning.jet.leave_one_group_out import HeldOutGroup
from q2q_sim.air.learning.residual.gain_spread import gain_spread
from q2q_sim.air.learning.residual.wake_residuals import WakeResiduals, wake_residuals, with_vehicle_gain
from q2q_sim.air.learning.statistics.autocovariance import lagged_pairs
from q2q_sim.air.learning.statistics.block_bootstrap import Row, block_of_rows, cell_sums, estimate_spread
from q2q_sim.air.learning.statistics.fitted import LearnedTerm, fitted_value, within_search

LEVELS = np.array([0.0, 0.25, 0.5, 1.0, 1.5, 2.0, 2.5, np.inf])
"""Bounds of the levels of |eta| [m/s^2]."""
FEWEST_ROWS = 300
"""Fewest exposed rows: 3 s at 100 Hz."""
START = np.array([0.3, 0.1, 0.08])
"""Floor [m/s^2], slope [-] and time [s] from which the fit starts."""
LOWEST, LARGEST = np.array([0.0, 0.0, 0.005]), np.array([2.0, 1.0, 1.0])
PATHS = ("residual.floor_mps2", "residual.slope", "residual.time_s")


def residual_term(
    groups: Sequence[HeldOutGroup], absorption: AbsorptionTerm | None
) -> LearnedTerm[ResidualTerm] | None:
    """Return what jets of other flights leave unexplained; None with fewer than FEWEST_ROWS exposed."""
    wakes = [wake for one in groups for wake in wake_residuals(one.records, one.jet, absorption)]
    rows = sum(int(wake.one.exposed.sum()) for wake in wakes)
    if rows < FEWEST_ROWS:
        return None
    lags = np.unique(np.concatenate([wake.lags.times for wake in wakes]))
    sums = _sums([with_vehicle_gain(wake) for wake in wakes], lags)
    found = estimate_spread(lambda weight: _fit(np.tensordot(weight, sums, 1), lags), len(sums))
    values = tuple(
        within_search(fitted_value(found, k, path, rows, "exposed rows"), (LOWEST[k], LARGEST[k]))
        for k, path in enumerate(PATHS)
    )
    gain = gain_spread(wakes)
    floor, slope, time = map(float, found.value)
    return LearnedTerm(ResidualTerm(floor, slope, time, gain.value), (*values, gain))


def _sums(wakes: Sequence[WakeResiduals], lags: Array) -> Array:
    """Return the sums over blocks, levels of |eta| and `lags` [s] of 1, e e' - C, a a', a b' + a' b, b b'.

    a = min(|eta| / e_0, 1), b = |eta|; (B, K, L, 5).
    """
    places, columns, level, lag = [], [], [], []
    for one in wakes:
        t = one.record.motion.t
        inside = np.minimum(one.eta / INSIDE, 1.0)
        column = np.searchsorted(lags, one.lags.times)
        for k, (first, second) in enumerate(lagged_pairs(one.one.exposed, one.lags)):
            a, b, a2, b2 = inside[first], one.eta[first], inside[second], one.eta[second]
            product = one.residual[first] * one.residual[second] - one.clear[k]
            columns.append(np.stack([np.ones(first.size), product, a * a2, a * b2 + a2 * b, b * b2], axis=1))
            level.append(np.searchsorted(LEVELS, 0.5 * (b + b2), side="right") - 1)
            lag.append(np.full(first.size, column[k]))
            places.append(Row(one.record.name, t[first]))
    cells = np.concatenate(level) * lags.size + np.concatenate(lag)
    sums = cell_sums(np.concatenate(columns), block_of_rows(places), cells, (LEVELS.size - 1) * lags.size)
    return np.asarray(sums.reshape(-1, LEVELS.size - 1, lags.size, 5))


def _fit(sums: Array, lags: Array) -> Array:
    """Return floor, slope and time of sums (K, L, 5) at lags [s], (L,)."""
    seen = sums[..., 0] > 0.0
    count = np.maximum(sums[..., 0], 1.0)
    mean = sums[..., 1:] / count[..., None]
    level = np.maximum(mean[:, :1, 0], 0.01)  # variance of each level; the least is that of 0.1 m/s^2
    weight = np.where(seen, np.sqrt(count) / level, 0.0)

    def residuals(x: Array) -> Array:
        floor, slope, time = x
        size = floor**2 * mean[..., 1] + floor * slope * mean[..., 2] + slope**2 * mean[..., 3]
        return np.asarray((weight * (mean[..., 0] - size * np.exp(-lags / time))).ravel())

    return np.asarray(least_squares(residuals, START, bounds=(LOWEST, LARGEST), x_scale=START).x)
