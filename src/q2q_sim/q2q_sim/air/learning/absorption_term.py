"""Part of a jet that a vehicle in it takes from those below, from rows under exactly two vehicles.

    y = - T_k P_k - (1 - c) T_j P_j,   c = max(share exp(-r^2 / 2 w^2), P(gap, r) / g)

k is the nearer source, j the farther, (gap, r) the place of k in the jet of j. Share and width have the least
squared error on a grid.
"""

from collections.abc import Sequence

import numpy as np

from q2q_model.signals.values import Array
from q2q_sim.air.air_terms import AbsorptionTerm, JetTerm
from q2q_sim.air.learning.jet import wake_rows
from q2q_sim.air.learning.jet.jet_coordinates import jet_place
from q2q_sim.air.learning.jet.jet_table import push_in_table
from q2q_sim.air.learning.jet.learned_downwash import absorption_factor, travel_of
from q2q_sim.air.learning.jet.wake_rows import WakeRows, rows_under_two
from q2q_sim.air.learning.records.air_record import AirRecord
from q2q_sim.air.learning.statistics.block_bootstrap import block_sums, estimate_spread, slope_spread
from q2q_sim.air.learning.statistics.fitted import Fitted, LearnedTerm, fitted_value, within_search

FEWEST_ROWS = 200
"""Fewest rows under two vehicles: 2 s at 100 Hz."""
SHARES = np.linspace(0.0, 1.0, 51)
WIDTHS = np.linspace(0.02, 0.2, 10)
"""Widths to choose from [m]: a rotor's radius to the reach of a jet."""
COAXIAL = 0.06
"""Radius within which two jets count as co-axial [m]: a standard deviation of the jet."""
SOURCE = "rows under two vehicles"


def absorption_term(records: Sequence[AirRecord], jet: JetTerm) -> LearnedTerm[AbsorptionTerm] | None:
    """Return the absorption; None with fewer than FEWEST_ROWS under two vehicles."""
    parts = rows_under_two(records)
    if sum(part.rows.size for part in parts) < FEWEST_ROWS:
        return None
    near, far = _pushes(parts, jet)
    place = _between(parts, jet)
    y = np.concatenate([part.y for part in parts])
    felt = push_in_table(jet, place[0], place[1])
    grid = [(share, width) for width in WIDTHS for share in SHARES]
    squared_residuals = np.stack(
        [
            (y + near + (1.0 - absorption_factor(place[1], felt, AbsorptionTerm(*one))) * far) ** 2
            for one in grid
        ],
        axis=1,
    )
    sums = block_sums(squared_residuals, wake_rows.row_blocks(parts))
    found = estimate_spread(lambda weight: np.array(grid[int(np.argmin(weight @ sums))]), len(sums))
    values = tuple(
        within_search(fitted_value(found, k, path, y.size, SOURCE), (choices[0], choices[-1]))
        for k, (path, choices) in enumerate((("absorption.share", SHARES), ("absorption.width_m", WIDTHS)))
    )
    return LearnedTerm(AbsorptionTerm(*map(float, found.value)), values)


def sum_of_two(records: Sequence[AirRecord], jet: JetTerm) -> Fitted | None:
    """Return how large two co-axial wakes together are over the sum of each alone.

    None with fewer than FEWEST_ROWS, or where the jet pushes in none of them.
    """
    parts = rows_under_two(records)
    if not parts:
        return None
    near, far = _pushes(parts, jet)
    coaxial = _between(parts, jet)[1] < COAXIAL
    if coaxial.sum() < FEWEST_ROWS:
        return None
    y, both = np.concatenate([part.y for part in parts])[coaxial], -(near + far)[coaxial]
    products = np.stack([y * both, both * both], axis=1)
    found = slope_spread(products, wake_rows.row_blocks(parts)[coaxial])
    return fitted_value(found, 0, "two wakes over their sum", y.size, SOURCE) if found else None


def _pushes(parts: Sequence[WakeRows], jet: JetTerm) -> tuple[Array, Array]:
    """Return T P of the nearer and of the farther source [m/s^2], (m,) each."""
    places = [wake_rows.jet_places(parts, travel_of(jet), source) for source in (0, 1)]
    near, far = (place.thrust_ratio * push_in_table(jet, place.gap, place.radius) for place in places)
    return near, far


def _between(parts: Sequence[WakeRows], jet: JetTerm) -> tuple[Array, Array]:
    """Return gap and radius of the nearer source in the jet of the farther, (m,) each."""
    pairs = [(part.sources[0], part.sources[1]) for part in parts]
    found = [
        jet_place(part.record, pair, part.rows, travel_of(jet))
        for part, pair in zip(parts, pairs, strict=True)
    ]
    return np.concatenate([one.gap for one in found]), np.concatenate([one.radius for one in found])
