"""Table of a jet's push P over gap and radius, compiled: bilinear between its knots."""

from typing import NamedTuple

import numpy as np

from q2q_model.compiled import HOT, compiled
from q2q_model.signals.values import Array, Rows
from q2q_sim.air.air_terms import AbsorptionTerm, JetTerm

LEAST_ABSORBED = 1e-3
"""Share of a jet below which nothing is absorbed by a vehicle that feels none of it [-]."""
MOST_BINS = 1000
"""Bins of knots at most: knots closer than a thousandth of their range share some."""


class Knots(NamedTuple):
    """Rising places of the nodes along one axis of a table."""

    at: Array
    """[m], (k,)."""
    cells: Rows
    """Cell in the middle of each of the bins into which 0 to the last knot is divided evenly, (bins,)."""
    per_m: float
    """Bins over length [1/m]."""


class PushTable(NamedTuple):
    """Table of P."""

    gaps: Knots
    radii: Knots
    push: Array
    """[m/s^2], (a, b)."""
    ends: Array
    """Radius within which a vehicle is in the jet [m], (a - 1,)."""


def ends_of_jet(jet: JetTerm, absorption: AbsorptionTerm | None) -> Array:
    """Return the radius within which a vehicle is in the jet between two gaps of the table [m], (a - 1,)."""
    radii = np.append(0.0, jet.radii_m[1:])
    felt = [np.flatnonzero(row)[-1] + 1 if row.any() else 0 for row in jet.push_mps2]
    ends = radii[np.minimum(felt, len(radii) - 1)]
    absorbing = 0.0
    if absorption is not None and absorption.share > LEAST_ABSORBED:
        absorbing = absorption.width_m * np.sqrt(2.0 * np.log(absorption.share / LEAST_ABSORBED))
    return np.asarray(np.clip(np.maximum(ends[:-1], ends[1:]), absorbing, radii[-1]))


def knots_of(at: Array) -> Knots:
    """Return knots at rising places (k,) from 0 on [m], with bins as wide as the narrowest cell."""
    bins = min(int(np.ceil(at[-1] / np.diff(at).min() - 1e-9)), MOST_BINS)
    middles = (np.arange(bins) + 0.5) * at[-1] / bins
    cells = np.clip(np.searchsorted(at, middles) - 1, 0, len(at) - 2)
    return Knots(np.ascontiguousarray(at), cells.astype(np.intp), bins / float(at[-1]))


@compiled(**HOT)
def cell(knots: Knots, value: float) -> int:
    """Return the last cell whose lower end is below `value` [m], searched from the cell of its bin."""
    at, last = knots.at, knots.at.shape[0] - 2
    ahead = value * knots.per_m if value > 0.0 else 0.0  # also of NaN, whose cell is any
    k: int = knots.cells[min(int(ahead), knots.cells.shape[0] - 1)]
    while k > 0 and value <= at[k]:
        k -= 1
    while k < last and value > at[k + 1]:
        k += 1
    return k


@compiled(**HOT)
def table_push(table: PushTable, a: int, gap: float, radius: float) -> float:
    """Return P [m/s^2] at a gap [m] in the table's cell a, and a radius [m]."""
    gaps, radii, push = table.gaps.at, table.radii.at, table.push
    b = cell(table.radii, radius)
    along = min(max((gap - gaps[a]) / (gaps[a + 1] - gaps[a]), 0.0), 1.0)
    aside = max((radius - radii[b]) / (radii[b + 1] - radii[b]), 0.0)
    near = (1.0 - aside) * push[a, b] + aside * push[a, b + 1]
    far = (1.0 - aside) * push[a + 1, b] + aside * push[a + 1, b + 1]
    return float((1.0 - along) * near + along * far)
