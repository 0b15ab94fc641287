"""Share of its push that a source feels upwards: y_i = u sum over j of P(z_i - z_j, dxy_ij), j below i."""

from collections.abc import Sequence

import numpy as np

from q2q_model.signals.values import Array, Rows
from q2q_sim.air.learning.jet.jet_splines import REACH, spline_values
from q2q_sim.air.learning.records.air_record import AirRecord
from q2q_sim.air.learning.statistics.block_bootstrap import Row, block_of_rows, slope_spread
from q2q_sim.air.learning.statistics.fitted import Fitted, fitted_value

FEWEST_ROWS = 100
"""Fewest upper rows: 1 s at 100 Hz."""
MOST = 1.0
"""Largest share of its push that a source feels."""


def upper_share(records: Sequence[AirRecord], beta: Array) -> Fitted | None:
    """Return u for the splines' coefficients (p,) of P; None if the upper rows do not show it.

    They are fewer than FEWEST_ROWS, P is 0 in all of them, or u or an end of its interval is beyond 1, more
    than the source gives.
    """
    parts = [(record, one) for record in records for one in record.samples if one.upper.any()]
    rows = [np.flatnonzero(one.upper) for _, one in parts]
    if sum(one.size for one in rows) < FEWEST_ROWS:
        return None
    y = np.concatenate([one.y[at] for (_, one), at in zip(parts, rows, strict=True)])
    push = np.concatenate(
        [_below(record, one.vehicle, at, beta) for (record, one), at in zip(parts, rows, strict=True)]
    )
    blocks = block_of_rows([Row(r.name, r.motion.t[at]) for (r, _), at in zip(parts, rows, strict=True)])
    found = slope_spread(np.stack([push * y, push * push], axis=1), blocks)
    if found is None or np.nanmax(np.abs([found.value, found.low, found.high])) > MOST:
        return None
    return fitted_value(found, 0, "jet.upper_ratio", y.size, "rows above one vehicle and below none")


def _below(record: AirRecord, i: int, rows: Rows, beta: Array) -> Array:
    """Return the sum of P of the pairs of i and each vehicle below it [m/s^2], (k,)."""
    pos = record.motion.pos[rows]
    total = np.zeros(rows.size)
    for j in range(record.vehicles):
        apart = pos[:, i] - pos[:, j]
        across = np.hypot(apart[:, 0], apart[:, 1])
        near = (apart[:, 2] > 0.0) & (across < REACH)
        total[near] += spline_values(apart[near, 2], across[near]) @ beta
    return total
