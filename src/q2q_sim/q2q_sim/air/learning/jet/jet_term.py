"""Mean downwash of one source: its table and how its air travels.

Slowness, carried and slope (jet_coordinates) are profiled: the best table (jet_splines) is solved for each,
and the simplex of Nelder and Mead minimises what is left. The bootstrap is linearised at the estimate: with
the Jacobian J = (X, Z) of coefficients above zero and travel, and the residuals e,

    (beta, travel)* - (beta, travel) = (sum w_g J_g' J_g + R)^-1 (sum w_g J_g' e_g - R beta)

with R, the matrix of the penalties, and a travel beyond its bounds at them. An item of the travel that is
at a bound at the estimate stays there. Where all w_g are 1 the step of beta is zero: the intervals are around
the estimate.

An item of the travel is not shown if even alone, with the scores z_g' e_g of the blocks,

    1.96 (sum over g of (z_g' e_g)^2)^1/2 / z' z > half of its bounds,

as the slope where no source tilts, and what is carried where there is no delay. It then is that of START.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import minimize

from q2q_model.identification.statistics.intervals import Z95
from q2q_model.signals.values import Array, Mask
from q2q_sim.air.air_terms import JetTerm
from q2q_sim.air.learning.jet import wake_rows
from q2q_sim.air.learning.jet.jet_coordinates import Travel
from q2q_sim.air.learning.jet.jet_splines import (
    DEFAULT_PENALTY,
    RIDGE,
    chosen_penalty,
    normal_equations,
    penalties,
    solve_penalised,
    solve_signed,
    spline_values,
    squared_error,
)
from q2q_sim.air.learning.jet.jet_table import GAPS, RADII, push_table
from q2q_sim.air.learning.jet.upper_share import upper_share
from q2q_sim.air.learning.jet.wake_rows import WakeRows, rows_under_one
from q2q_sim.air.learning.records.air_record import AirRecord
from q2q_sim.air.learning.statistics.block_bootstrap import BlockOfRows, Spread, block_sums, estimate_spread
from q2q_sim.air.learning.statistics.fitted import Fitted, LearnedTerm, at_bound, fitted_value

FEWEST_ROWS = 300
"""Fewest exposed rows for a jet: 3 s at 100 Hz."""
FLOWN = (0.01, 0.99)
"""Quantiles of the exposed rows' gaps between which the table is measured."""
START = Travel(slowness=0.25, carried=0.8, slope=1.0)
"""Travel to begin with, near that of real flights, and of what flights do not show."""
BOUNDS = ((0.0, 1.0), (0.0, 1.5), (0.0, 1.5))
"""Bounds of the travel: no delay to 1 m/s, nothing kept to half more than all."""
STILL = 1e-3
"""Slowness below which there is no delay [s/m]: a tenth of a tick over 1 m."""
REFERENCE = 0.4
"""Gap at which the push on the axis is reported [m]."""
STEP = 1e-2
"""Step of the derivatives by travel."""
TOLERANCE = 5e-3
"""Tolerance of the travel: a tenth of its interval on the longest recordings."""


def jet_term(records: Sequence[AirRecord]) -> LearnedTerm[JetTerm] | None:
    """Return the jet; None if fewer than FEWEST_ROWS lie under exactly one vehicle."""
    parts = _enough(records)
    if parts is None:
        return None
    fit, rows = _Fit(parts), sum(int(part.exposed.sum()) for part in parts)
    low, high = fit.flown
    upper = upper_share(records, fit.beta)
    source = f"rows under one vehicle, {low:.2f} to {high:.2f} m below it"
    found = fit.spread()
    values = [fitted_value(found, k, path, rows, source) for k, path in enumerate(_PATHS)]
    values[1:] = [
        _reported_value(*one) for one in zip(values[1:], fit.travel, BOUNDS, fit.shown, strict=True)
    ]
    term = fit.term(upper.value if upper else 0.0)
    return LearnedTerm(term, (*values, upper) if upper else tuple(values))


def _reported_value(one: Fitted, item: float, bounds: tuple[float, float], shown: bool) -> Fitted:
    """Return a value of the travel, without interval if it is not shown, or at its bound."""
    if not shown:
        return replace(one, low=None, high=None, rows=0, source="not shown by these flights: the default")
    return at_bound(one) if _is_at(item, bounds) else one


def _is_at(item: float, bounds: tuple[float, float]) -> bool:
    """Return whether an item of the travel is at a bound of its search."""
    return min(abs(item - end) for end in bounds) < TOLERANCE


def jet_alone(records: Sequence[AirRecord]) -> JetTerm | None:
    """Return the jet as `jet_term` does, without intervals and without what its source feels."""
    parts = _enough(records)
    return _Fit(parts).term(0.0) if parts else None


def _enough(records: Sequence[AirRecord]) -> list[WakeRows] | None:
    """Return the rows under exactly one vehicle, None if fewer than FEWEST_ROWS are exposed."""
    parts = rows_under_one(records)
    return parts if sum(int(part.exposed.sum()) for part in parts) >= FEWEST_ROWS else None


_PATHS = ("jet.push_mps2", "jet.travel_speed_mps", "jet.carried", "jet.slope")


class _Fit:
    """Fitted table and travel of all rows."""

    def __init__(self, parts: Sequence[WakeRows]) -> None:
        self._parts, self._blocks = parts, wake_rows.row_blocks(parts)
        self._y = np.concatenate([part.y for part in parts])
        self._solve(self._travel(np.ones(len(START), dtype=bool)))
        self.shown = self._shown()
        if not self.shown.all():
            self._solve(self._travel(self.shown))
        self.flown = self._flown()

    def _solve(self, travel: Travel) -> None:
        """Find the table for a travel."""
        self.travel = travel
        normal = normal_equations(wake_rows.jet_places(self._parts, travel), self._y, self._blocks)
        self._penalty = chosen_penalty(normal)
        self.beta = solve_penalised(normal, np.ones(normal.power.size), self._penalty)

    def _shown(self) -> Mask:
        """Return which items of the travel the rows show, (3,)."""
        residual, found = self._y + self._push(self.travel), []
        for k, (low, high) in enumerate(BOUNDS):
            along = self._derivative(k)
            wide = Z95 * float(np.linalg.norm(block_sums(along * residual, self._blocks)))
            found.append(wide < 0.5 * (high - low) * float(along @ along))
        return np.array(found)

    def _flown(self) -> tuple[float, float]:
        """Return the gaps between which the table is measured [m]."""
        exposed = np.concatenate([part.exposed for part in self._parts])
        low, high = np.quantile(wake_rows.jet_places(self._parts, self.travel).gap[exposed], FLOWN)
        return float(low), float(high)

    def term(self, upper_ratio: float) -> JetTerm:
        """Return the jet, given the share of its push that the source feels."""
        return JetTerm(
            gaps_m=GAPS,
            radii_m=RADII,
            push_mps2=push_table(self.beta, self.flown),
            upper_ratio=upper_ratio,
            travel_speed_mps=1.0 / max(self.travel.slowness, STILL),
            carried=self.travel.carried,
            slope=self.travel.slope,
        )

    def _travel(self, free: Mask) -> Travel:
        """Return the best travel whose items that are not `free` are those of START."""
        if not free.any():
            return START
        together: BlockOfRows = np.zeros(self._y.size, dtype=np.intp)
        one = np.ones(1)

        def moved(x: Array) -> Travel:
            travel = np.array(START)
            travel[free] = x
            return Travel(*map(float, travel))

        def squared_residuals(x: Array) -> float:
            place = wake_rows.jet_places(self._parts, moved(x))
            normal = normal_equations(place, self._y, together)
            return squared_error(normal, one, solve_signed(normal, one, DEFAULT_PENALTY))

        found = minimize(
            squared_residuals,
            np.array(START)[free],
            method="Nelder-Mead",
            bounds=np.array(BOUNDS)[free],
            options={"xatol": TOLERANCE, "fatol": 1e-4 * float(self._y @ self._y)},
        )
        return moved(found.x)

    def _push(self, travel: Travel) -> Array:
        place = wake_rows.jet_places(self._parts, travel)
        return np.asarray(place.thrust_ratio * (spline_values(place.gap, place.radius) @ self.beta))

    def spread(self) -> Spread:
        """Return the push at REFERENCE on the axis, the travel speed, carried and slope, with intervals."""
        active = np.flatnonzero(self.beta > 0.0)
        place = wake_rows.jet_places(self._parts, self.travel)
        along = -place.thrust_ratio[:, None] * spline_values(place.gap, place.radius)[:, active]
        free = self.shown & ~np.array([_is_at(*one) for one in zip(self.travel, BOUNDS, strict=True)])
        moved = [self._derivative(int(k)) for k in np.flatnonzero(free)]
        jacobian = np.column_stack([along, *moved])
        residual = self._y + self._push(self.travel)
        rough = RIDGE * np.eye(jacobian.shape[1])
        rough[: active.size, : active.size] = penalties(self._penalty)[np.ix_(active, active)]
        smoothed = rough[:, : active.size] @ self.beta[active]
        score = block_sums(jacobian * residual[:, None], self._blocks)
        count = int(self._blocks.max()) + 1
        squares = np.stack([_square(jacobian[self._blocks == k]) for k in range(count)])
        least, most = np.array(BOUNDS).T

        def estimate(weight: Array) -> Array:
            square = np.tensordot(weight, squares, 1) + rough
            step = np.linalg.solve(square, weight @ score - smoothed)
            beta, travel = self.beta.copy(), np.array(self.travel)
            beta[active] += step[: active.size]
            travel[free] += step[active.size :]
            travel = np.clip(travel, least, most)
            return self._values(beta, Travel(*travel))

        return replace(estimate_spread(estimate, count), value=self._values(self.beta, self.travel))

    def _values(self, beta: Array, travel: Travel) -> Array:
        """Return the push at REFERENCE on the axis, the travel speed, carried and slope, (4,)."""
        push = push_table(beta, self.flown)[np.searchsorted(GAPS, REFERENCE), 0]
        return np.array([push, 1.0 / max(travel.slowness, STILL), travel.carried, travel.slope])

    def _derivative(self, k: int) -> Array:
        """Return the derivative of -P with respect to item k of the travel, (m,)."""
        ahead, behind = (
            Travel(*(value + sign * STEP * (item == k) for item, value in enumerate(self.travel)))
            for sign in (1.0, -1.0)
        )
        return (self._push(behind) - self._push(ahead)) / (2.0 * STEP)


def _square(rows: Array) -> Array:
    return np.asarray(rows.T @ rows)
