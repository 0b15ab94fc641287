"""Drag of the rotors, from accelerometers in clear air.

    a = -k (v - (v . b) b)        b: body z, v: velocity [m/s], k: drag [1/s]

A rotor in translation is pushed back in its own plane, in proportion to the speed (Faessler, Franchi and
Scaramuzza, RA-L 2018). Thrust has no part in the plane, so an accelerometer shows nothing else there but its
bias: k is the slope of its x and y over the velocity in body axes.
"""

from collections.abc import Sequence

import numpy as np

from q2q_model.geometry.rotations import rotate_inverse
from q2q_model.signals.values import Array
from q2q_sim.air.air_terms import RotorDragTerm
from q2q_sim.air.learning.records.air_record import AirRecord
from q2q_sim.air.learning.statistics.block_bootstrap import Row, block_of_rows, block_sums, estimate_spread
from q2q_sim.air.learning.statistics.fitted import LearnedTerm, fitted_value, not_negative

FEWEST_ROWS = 200
"""Fewest rows of a vehicle in clear air: 2 s at 100 Hz."""
LEAST_SPEED = 0.1
"""Minimum rms speed of a vehicle in its plane [m/s]: a hovering one does not show the drag."""


def rotor_drag_term(records: Sequence[AirRecord]) -> LearnedTerm[RotorDragTerm] | None:
    """Return the drag; None without a vehicle that moves for FEWEST_ROWS in clear air."""
    products, places = [], []
    for record in records:
        for i in range(record.vehicles):
            rows = record.felt[:, i]
            if rows.sum() < FEWEST_ROWS:
                continue
            felt, moved = (
                rotate_inverse(record.quat[rows, i], values[rows, i])[:, :2]
                for values in (record.specific_force, record.motion.vel)
            )
            felt, moved = felt - felt.mean(axis=0), moved - moved.mean(axis=0)
            if np.sqrt((moved**2).mean()) > LEAST_SPEED:
                products.append(np.stack([-(felt * moved).sum(axis=1), (moved**2).sum(axis=1)], axis=1))
                places.append(Row(record.name, record.motion.t[rows]))
    if not products:
        return None
    sums = block_sums(np.concatenate(products), block_of_rows(places))

    def estimate(weight: Array) -> Array:
        along, square = weight @ sums
        return np.array([max(along / square, 0.0)])

    rows_found = sum(len(one) for one in products)
    drag = estimate_spread(estimate, len(sums))
    found = not_negative(fitted_value(drag, 0, "rotor_drag.per_s", rows_found, "rows in clear air"))
    return LearnedTerm(RotorDragTerm(found.value), (found,))
