"""Growth of thrust near the ground, from flights of single vehicles close to it.

    (R f)_z / (T b_z / m) over its median away from the ground = 1 + b (R / z)^2

The form is that of Cheeseman and Bennett (The effect of the ground on a helicopter rotor in forward flight,
ARC R&M 3021, 1955) for small R / z, 1 / (1 - (R / 4 z)^2) with b = 1 / 16 for one rotor; four rotors near
each other have a larger one. z is the height of the tracked point, near the rotors, above that of a
vehicle that stands: lower, the square would double the thrust of a vehicle that lands, which nobody measured.
"""

from collections.abc import Sequence

import numpy as np

from q2q_model.identification.push.push_samples import APART, FLOOR
from q2q_model.signals.values import Array, Mask
from q2q_model.vehicle.constants import ROTOR_RADIUS
from q2q_sim.air.air_terms import ON_THE_GROUND, GroundTerm
from q2q_sim.air.learning.records.air_record import AirRecord, rows_alone
from q2q_sim.air.learning.statistics.block_bootstrap import Row, block_of_rows, slope_spread
from q2q_sim.air.learning.statistics.fitted import Fitted, LearnedTerm, fitted_value

NEAR = 0.15
"""Height below which a row shows the ground effect [m]: six rotor radii."""
FEWEST_ROWS = 200
"""Fewest such rows: 2 s at 100 Hz."""
ONE_ROTOR = 1.0 / 16.0
"""b of one rotor: Cheeseman and Bennett, 1955."""


def ground_term(records: Sequence[AirRecord]) -> LearnedTerm[GroundTerm]:
    """Return the ground effect, or that of one rotor where too few rows are near the ground."""
    places, products, rows = [], [], 0
    for record in records:
        for i, near in enumerate(_near_ground(record).T):
            if near.any() and (away := _away(record)[:, i]).sum() >= FEWEST_ROWS:
                ratio = _ratio(record, i)
                gain = ratio[near] / np.median(ratio[away]) - 1.0
                closeness = (ROTOR_RADIUS / record.motion.pos[near, i, 2]) ** 2
                places.append(Row(record.name, record.motion.t[near]))
                products.append(np.stack([closeness * gain, closeness**2], axis=1))
                rows += int(near.sum())
    spread = slope_spread(np.concatenate(products), block_of_rows(places)) if rows >= FEWEST_ROWS else None
    if spread is None:
        value = Fitted(
            "ground.coefficient", ONE_ROTOR, None, None, rows, "not learned: Cheeseman and Bennett 1955"
        )
        return LearnedTerm(GroundTerm(ONE_ROTOR, ROTOR_RADIUS), (value,))
    found = fitted_value(spread, 0, "ground.coefficient", rows, f"rows below {NEAR} m")
    return LearnedTerm(GroundTerm(found.value, ROTOR_RADIUS), (found,))


def _near_ground(record: AirRecord) -> Mask:
    height = record.motion.pos[..., 2]
    return np.asarray(_flying(record) & (height > ON_THE_GROUND) & (height < NEAR))


def _away(record: AirRecord) -> Mask:
    return np.asarray(_flying(record) & (record.motion.pos[..., 2] > FLOOR))


def _flying(record: AirRecord) -> Mask:
    return np.asarray(record.measured & record.flying & rows_alone(record.motion.pos, APART))


def _ratio(record: AirRecord, i: int) -> Array:
    """Return acceleration over thrust [1/kg], (T,)."""
    lift = np.maximum(record.thrust[:, i] * record.motion.axis[:, i, 2], np.finfo(float).tiny)
    return np.asarray(record.specific_force[:, i, 2] / lift)
