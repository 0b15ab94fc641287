"""Roll and pitch torque at the edge of a wake, from what the motors do against it.

    tau + c w = tau_wake,    tau_wake . (e_z x n) = T peak (r / r_0) exp((1 - r^2 / r_0^2) / 2)

tau is what the motors do not explain (outer_torque), c w the torque against the rates (rate_load_term). n
points horizontally from the vehicle to the jet's axis, so a positive torque tips the vehicle towards it; T is
the thrust ratio of the source.
"""

from collections.abc import Sequence

import numpy as np

from q2q_model.geometry.rotations import rotate
from q2q_model.identification.push.push_samples import UNDER
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import Vehicle
from q2q_sim.air.air_terms import EdgeTorqueTerm, JetTerm
from q2q_sim.air.learning.jet import wake_rows
from q2q_sim.air.learning.jet.jet_coordinates import jet_place
from q2q_sim.air.learning.jet.learned_downwash import travel_of
from q2q_sim.air.learning.jet.wake_rows import WakeRows, rows_under_one
from q2q_sim.air.learning.records.air_record import AirRecord
from q2q_sim.air.learning.records.motor_curve import motor_curves, usual_power
from q2q_sim.air.learning.records.outer_torque import has_trim, outer_torque
from q2q_sim.air.learning.statistics.block_bootstrap import block_sums, estimate_spread
from q2q_sim.air.learning.statistics.fitted import LearnedTerm, fitted_value, within_search

LEAST_GAP = 0.15
"""Minimum gap of rows [m]: closer, vehicles swap heights and turn hard."""
RADII = np.linspace(0.02, 0.12, 21)
"""Radii of the largest torque to choose from [m]."""
FEWEST_ROWS = 300
"""Fewest rows: 3 s at 100 Hz."""
SOURCE = "rows under one vehicle with a motor log"
PATHS = ("edge_torque.peak_nm", "edge_torque.radius_m")


def edge_torque_term(
    records: Sequence[AirRecord], jet: JetTerm, vehicle: Vehicle, load: float = 0.0
) -> LearnedTerm[EdgeTorqueTerm] | None:
    """Return the torque in addition to that of a load of the rates [N m s].

    None with fewer than FEWEST_ROWS of vehicles with a motor log and an attitude under one other.
    """
    parts = _inner(rows_under_one(records), jet)
    rows = sum(part.rows.size for part in parts)
    if rows < FEWEST_ROWS:
        return None
    place = wake_rows.jet_places(parts, travel_of(jet))
    ratio = place.radius[:, None] / RADII
    profile = place.thrust_ratio[:, None] * ratio * np.exp(0.5 * (1.0 - ratio**2))  # (m, R)
    power = usual_power(motor_curves(records))
    wake = np.concatenate([_wake_torque(part, vehicle, power, load) for part in parts])  # (m, 2)
    across = np.stack([-place.toward[:, 1], place.toward[:, 0]], axis=1)  # e_z x n
    torque = np.sum(wake * across, axis=1)
    sums = block_sums(np.stack([profile * torque[:, None], profile**2], axis=1), wake_rows.row_blocks(parts))

    def estimate(weight: Array) -> Array:
        along, square = np.tensordot(weight, sums, 1)
        best = int(np.argmax(along**2 / square))  # the largest reduction of the squared error
        return np.array([along[best] / square[best], RADII[best]])

    found = estimate_spread(estimate, len(sums))
    peak, radius = (fitted_value(found, k, path, rows, SOURCE) for k, path in enumerate(PATHS))
    values = (peak, within_search(radius, (RADII[0], RADII[-1])))
    return LearnedTerm(EdgeTorqueTerm(*map(float, found.value)), values)


def _inner(parts: Sequence[WakeRows], jet: JetTerm) -> list[WakeRows]:
    """Return the rows as near to the axis as exposed ones, with known motors, trim and attitude."""
    found = []
    for part in parts:
        record, i = part.record, part.one.vehicle
        if has_trim(record, i):
            place = jet_place(record, (i, part.sources[0]), part.rows, travel_of(jet))
            turned = np.isfinite(record.quat[part.rows, i]).all(axis=-1)
            near = (place.radius < UNDER) & (place.gap > LEAST_GAP) & turned
            if near.any():
                found.append(WakeRows(record, part.one, part.sources, part.rows[near]))
    return found


def _wake_torque(part: WakeRows, vehicle: Vehicle, power: float, load: float) -> Array:
    """Return the torque of a wake [N m], world x and y, (k, 2)."""
    record, i, rows = part.record, part.one.vehicle, part.rows
    body = outer_torque(record, i, vehicle, power)[rows] + load * record.rate_body[rows, i, :2]
    upright = np.column_stack([body, np.zeros(len(body))])
    return np.asarray(rotate(record.quat[rows, i], upright)[:, :2])
