"""Gusts in clear air: the part of the measured vertical force that stays correlated for longer than noise.

    E y(t) y(t + l) = s^2 exp(-l / T)        for lags l beyond the correlation of sensor and rotor noise

A steady wind and the bias of an accelerometer (0.1 m/s^2 horizontally on the recorded flights) give the same
record, so the mean is zero; the vertical one is the vehicles' offset (vehicle_term). What is left contains
the errors of the thrust map in manoeuvres, so it bounds the gusts from above.
"""

from collections.abc import Sequence

import numpy as np
from scipy.optimize import least_squares

from q2q_model.signals.values import Array
from q2q_sim.air.learning.evidence.air_record import AirRecord
from q2q_sim.air.learning.evidence.autocovariance import pairs, ticks
from q2q_sim.air.learning.evidence.block_bootstrap import Row, blocks_of, cell_sums, spread
from q2q_sim.air.learning.evidence.fitted import LearnedTerm, fitted
from q2q_sim.air.room_air import WindTerm

LAGS = np.array([0.05, 0.08, 0.12, 0.16, 0.2, 0.3, 0.4, 0.6, 0.8, 1.0])
"""Lags of the autocovariance [s]; noise of accelerometer and rotors is correlated for 0.03 s."""
FEWEST = 500
"""Fewest rows in clear air: 5 s at 100 Hz."""
START = np.array([0.1, 0.2])
LOWEST, LARGEST = np.array([0.0, 0.01]), np.array([3.0, 10.0])
SCALE = np.array([0.1, 0.1])
PATHS = ("wind.gust_std_mps2", "wind.gust_time_s")


def wind_term(records: Sequence[AirRecord]) -> LearnedTerm[WindTerm] | None:
    """Return the gusts; None with fewer than FEWEST rows in clear air."""
    parts = [(r, one) for r in records for one in r.samples if r.clear[:, one.vehicle].any()]
    rows = sum(int(r.clear[:, one.vehicle].sum()) for r, one in parts)
    if rows < FEWEST:
        return None
    places, products, lags = [], [], []
    for record, one in parts:
        known, t = record.clear[:, one.vehicle], record.motion.t
        y = one.y - one.y[known].mean()
        for k, lag in enumerate(ticks(t, LAGS)):
            first, second = pairs(known, int(lag))
            places.append(Row(record.name, t[first]))
            products.append(np.stack([np.ones(first.size), y[first] * y[second]], axis=1))
            lags.append(np.full(first.size, k))
    sums = cell_sums(np.concatenate(products), blocks_of(places), np.concatenate(lags), LAGS.size)
    found = spread(lambda weight: _fit(np.tensordot(weight, sums, 1)), len(sums))
    std, time = map(float, found.value)
    values = tuple(fitted(found, k, path, rows, "rows in clear air") for k, path in enumerate(PATHS))
    return LearnedTerm(WindTerm((0.0, 0.0, 0.0), std, time), values)


def _fit(sums: Array) -> Array:
    """Return standard deviation and time of the counts and sums of products, (L, 2)."""
    weight = np.sqrt(sums[:, 0])
    mean = sums[:, 1] / np.maximum(sums[:, 0], 1.0)

    def missed(x: Array) -> Array:
        return np.asarray(weight * (mean - x[0] ** 2 * np.exp(-LAGS / x[1])))

    return np.asarray(least_squares(missed, START, bounds=(LOWEST, LARGEST), x_scale=SCALE).x)
