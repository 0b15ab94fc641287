"""Lateral push under a wake: the mean of the radial acceleration not due to thrust, by radius.

    radial = n . [(R f)_xy - T b_xy / m - its median in clear air],   n: unit vector to the jet's axis

No term of an air has it: it is reported so that one can see that it is negligible.
"""

from collections.abc import Sequence

import numpy as np

from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import GRAVITY
from q2q_sim.air.air_terms import JetTerm
from q2q_sim.air.learning.jet import wake_rows
from q2q_sim.air.learning.jet.learned_downwash import travel_of
from q2q_sim.air.learning.jet.wake_rows import WakeRows, rows_under_one
from q2q_sim.air.learning.records.air_record import AirRecord
from q2q_sim.air.learning.statistics.block_bootstrap import cell_sums, estimate_spread
from q2q_sim.air.learning.statistics.fitted import Fitted, fitted_value

RINGS = np.array([0.0, 0.03, 0.06, 0.09, 0.12, 0.15])
"""Bounds of the rings by radius [m]."""
FEWEST_CLEAR = 100
"""Fewest rows in clear air: 1 s at 100 Hz."""
PATH = "largest radial mean"


def lateral_push(records: Sequence[AirRecord], jet: JetTerm) -> Fitted | None:
    """Return the mean radial acceleration [m/s^2] of the ring where it is largest, positive inwards."""
    parts = [p for p in rows_under_one(records) if p.record.felt[:, p.one.vehicle].sum() >= FEWEST_CLEAR]
    if not parts:
        return None
    place = wake_rows.jet_places(parts, travel_of(jet))
    radial = np.sum(np.concatenate([_lateral(part) for part in parts]) * place.toward, axis=1)
    ring = np.searchsorted(RINGS, place.radius, side="right") - 1
    inside = ring < RINGS.size - 1
    values = np.stack([np.ones(radial.size), radial], axis=1)[inside]
    sums = cell_sums(values, wake_rows.row_blocks(parts)[inside], ring[inside], RINGS.size - 1)

    def means(weight: Array) -> Array:
        total = np.tensordot(weight, sums, 1)
        return np.asarray(total[:, 1] / np.maximum(total[:, 0], 1.0))

    found = estimate_spread(means, len(sums))
    k = int(np.argmax(np.abs(found.value)))
    ring_name = f"rows at {RINGS[k] * 100:.0f} to {RINGS[k + 1] * 100:.0f} cm, m/s^2"
    return fitted_value(found, k, PATH, int(inside.sum()), ring_name)


def _lateral(part: WakeRows) -> Array:
    """Return the horizontal acceleration not due to thrust [m/s^2], world, (k, 2)."""
    record, i = part.record, part.one.vehicle
    lift = GRAVITY * record.thrust_ratio[:, i, None] * record.motion.axis[:, i, :2]
    left = record.specific_force[:, i, :2] - lift
    return np.asarray(left[part.rows] - np.median(left[record.felt[:, i]], axis=0))
