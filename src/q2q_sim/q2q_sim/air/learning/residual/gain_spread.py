"""How much the gains of vehicles on a wake differ between vehicles and flights."""

from collections.abc import Sequence

import numpy as np

from q2q_model.signals.values import Array
from q2q_sim.air.learning.residual.wake_residuals import WakeResiduals, vehicle_gain
from q2q_sim.air.learning.statistics.block_bootstrap import Row, block_of_rows, block_sums, estimate_spread
from q2q_sim.air.learning.statistics.fitted import Fitted, fitted_value

FEWEST_ROWS = 100
"""Fewest exposed rows of a vehicle for its gain: 1 s at 100 Hz."""
FEWEST_STRETCHES = 3
"""Fewest stretches of 2 s with exposed rows of a vehicle for the error of its gain."""
PATH = "residual.gain_std"


def gain_spread(wakes: Sequence[WakeResiduals]) -> Fitted:
    """Return the standard deviation of the gain on the mean downwash between vehicles and flights.

    It is what the gains differ by beyond their own errors (DerSimonian and Laird, Controlled Clinical
    Trials 7, 1986, with even weights), each error from stretches of 2 s.
    """
    gains, errors = [], []
    for one in wakes:
        rows = np.flatnonzero(one.one.exposed)
        pair = np.stack([-one.one.y[rows] * one.eta[rows], one.eta[rows] ** 2], axis=1)
        sums = block_sums(pair, block_of_rows([Row(one.record.name, one.record.motion.t[rows])]))
        if rows.size >= FEWEST_ROWS and len(sums) >= FEWEST_STRETCHES:
            gain = vehicle_gain(one)
            residual = sums[:, 0] - gain * sums[:, 1]
            gains.append(gain)
            errors.append(float(residual @ residual) / sums[:, 1].sum() ** 2)
    each, own = np.array(gains), np.array(errors)

    def estimate(weight: Array) -> Array:
        if weight.sum() < 2.0:
            return np.zeros(1)
        mean = weight @ each / weight.sum()
        between = weight @ (each - mean) ** 2 / (weight.sum() - 1.0) - weight @ own / weight.sum()
        return np.array([np.sqrt(max(between, 0.0))])

    found = estimate_spread(estimate, each.size)
    return fitted_value(found, 0, PATH, each.size, "flights of vehicles under another")
