"""Gusts in clear air: the part of the measured vertical push that stays correlated for longer than noise.

    E y(t) y(t + l) = s^2 exp(-l / T)        for lags l beyond the correlation of sensor and rotor noise

for each vehicle of each flight; their median counts. Manoeuvres beside other vehicles leave more than air
does (0.17 to 0.30 m/s^2 in random walks of several, 0.05 to 0.11 in swaps and alone), and pooled rows would
be theirs. A steady wind and the bias of an accelerometer (0.1 m/s^2 horizontally on the recorded flights)
give the same record, so the mean is zero; the vertical one is the vehicles' offset (vehicle_term).
"""

from collections.abc import Sequence

import numpy as np
from scipy.optimize import least_squares

from q2q_model.identification.push.push_samples import PushSamples
from q2q_model.signals.values import Array
from q2q_sim.air.air_terms import WindTerm
from q2q_sim.air.learning.records.air_record import AirRecord
from q2q_sim.air.learning.statistics.autocovariance import Lags, flight_lags, lagged_pairs
from q2q_sim.air.learning.statistics.fitted import LearnedTerm, fitted_value, within_search
from q2q_sim.air.learning.statistics.vehicle_spread import median_spread

LAGS = np.array([0.05, 0.08, 0.12, 0.16, 0.2, 0.3, 0.4, 0.6, 0.8, 1.0])
"""Lags of the autocovariance [s], or those of a flight nearest to them; noise is correlated for 0.03 s."""
FEWEST_ROWS = 500
"""Fewest rows of a vehicle in clear air: 5 s at 100 Hz."""
START = np.array([0.1, 0.2])
LOWEST, LARGEST = np.array([0.0, 0.01]), np.array([3.0, 10.0])
SCALE = np.array([0.1, 0.1])
PATHS = ("wind.gust_std_mps2", "wind.gust_time_s")


def wind_term(records: Sequence[AirRecord]) -> LearnedTerm[WindTerm] | None:
    """Return the gusts; None without a vehicle with FEWEST_ROWS in clear air."""
    parts = [(r, one) for r in records for one in r.samples if r.clear[:, one.vehicle].sum() >= FEWEST_ROWS]
    if not parts:
        return None
    each = np.array([_gusts(record, one) for record, one in parts])  # (parts, 2)
    found = median_spread(each, 0.0)
    std, time = map(float, found.value)
    source = "flights of vehicles with rows in clear air"
    values = tuple(
        within_search(fitted_value(found, k, path, len(each), source), (LOWEST[k], LARGEST[k]))
        for k, path in enumerate(PATHS)
    )
    return LearnedTerm(WindTerm((0.0, 0.0, 0.0), std, time), values)


def _gusts(record: AirRecord, one: PushSamples) -> Array:
    """Return standard deviation and time of the gusts on one vehicle, (2,)."""
    lags = flight_lags(record.motion.t, LAGS)
    return _fit(_sums(record, one, lags), lags.times)


def _sums(record: AirRecord, one: PushSamples, lags: Lags) -> Array:
    """Return the count and the sum of products at each lag, (L, 2)."""
    known = record.clear[:, one.vehicle]
    y = one.y - one.y[known].mean()
    found = []
    for first, second in lagged_pairs(known, lags):
        found.append([float(first.size), float(y[first] @ y[second])])
    return np.array(found)


def _fit(sums: Array, lags: Array) -> Array:
    """Return standard deviation and time of the counts and sums of products (L, 2) at lags [s], (L,)."""
    weight = np.sqrt(sums[:, 0])
    mean = sums[:, 1] / np.maximum(sums[:, 0], 1.0)

    def residuals(x: Array) -> Array:
        return np.asarray(weight * (mean - x[0] ** 2 * np.exp(-lags / x[1])))

    return np.asarray(least_squares(residuals, START, bounds=(LOWEST, LARGEST), x_scale=SCALE).x)
