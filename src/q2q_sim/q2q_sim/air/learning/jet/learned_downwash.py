"""Mean downwash along a recorded flight by a learned jet and absorption, as q2q_sim.air flies it.

eta_i = - sum over j of prod over k (1 - c_kj) T_j / (m g) P(gap_ij, r_ij)      k: vehicles between j and i
c_kj  = max(share exp(-r_kj^2 / 2 w^2), P(gap_kj, r_kj) / g)
"""

import numpy as np

from q2q_model.signals.values import Array, Mask, Rows
from q2q_model.vehicle.constants import GRAVITY
from q2q_sim.air.air_terms import AbsorptionTerm, JetTerm
from q2q_sim.air.learning.jet.jet_coordinates import Travel, jet_place
from q2q_sim.air.learning.jet.jet_table import push_in_table
from q2q_sim.air.learning.jet.wake_rows import CLOSEST, HIGHEST, NEAR
from q2q_sim.air.learning.records.air_record import AirRecord


def travel_of(jet: JetTerm) -> Travel:
    """Return how the air of a jet travels."""
    return Travel(1.0 / jet.travel_speed_mps, jet.carried, jet.slope)


def learned_downwash(
    record: AirRecord, i: int, rows: Rows, jet: JetTerm, absorption: AbsorptionTerm | None
) -> Array:
    """Return |eta| of vehicle i at rows (k,), [m/s^2]."""
    total = np.zeros(rows.size)
    for j in (other for other in range(record.vehicles) if other != i):
        near = _is_above(record, i, j, rows)
        place = jet_place(record, (i, j), rows[near], travel_of(jet))
        left = np.ones(place.gap.size)
        for k in (other for other in range(record.vehicles) if other not in (i, j)):
            between = _is_above(record, i, k, rows[near]) & _is_above(record, k, j, rows[near])
            taken = jet_place(record, (k, j), rows[near], travel_of(jet))
            left *= np.where(
                between,
                1.0
                - absorption_factor(taken.radius, push_in_table(jet, taken.gap, taken.radius), absorption),
                1.0,
            )
        total[near] += left * place.thrust_ratio * push_in_table(jet, place.gap, place.radius)
    return total


def absorption_factor(radius: Array, felt: Array, absorption: AbsorptionTerm | None) -> Array:
    """Return c of a vehicle at a radius [m] in a jet of which it feels `felt` [m/s^2], (k,)."""
    least = felt / GRAVITY
    if absorption is None:
        return least
    return np.maximum(absorption.share * np.exp(-0.5 * (radius / absorption.width_m) ** 2), least)


def _is_above(record: AirRecord, i: int, j: int, rows: Rows) -> Mask:
    """Return whether j is near enough above i to act on it, (k,)."""
    rel = record.motion.pos[rows, j] - record.motion.pos[rows, i]
    return np.asarray((np.hypot(rel[:, 0], rel[:, 1]) < NEAR) & (rel[:, 2] > CLOSEST) & (rel[:, 2] < HIGHEST))
