"""How much the gains of vehicles on a wake differ between vehicles and flights."""

from collections.abc import Sequence

import numpy as np

from q2q_sim.air.learning.residual.wake_residuals import WakeResiduals, vehicle_gain
from q2q_sim.air.learning.statistics.block_bootstrap import Row, block_of_rows, block_sums
from q2q_sim.air.learning.statistics.fitted import Fitted, fitted_value
from q2q_sim.air.learning.statistics.vehicle_spread import deviation_of_draws

FEWEST_ROWS = 100
"""Fewest exposed rows of a vehicle for its gain: 1 s at 100 Hz."""
FEWEST_STRETCHES = 3
"""Fewest stretches of 2 s with exposed rows of a vehicle for the error of its gain."""
PATH = "residual.gain_std"
SOURCE = "flights of vehicles under another"


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
    if not gains:
        return Fitted(PATH, 0.0, None, None, 0, SOURCE)
    return fitted_value(
        deviation_of_draws(np.array(gains), float(np.mean(errors))), 0, PATH, len(gains), SOURCE
    )
