"""Gains of the altitude loop from trajectories alone, (12)-(13): by the paper's method, and exactly.

    min over K_p, K_d >= 0 of sum over t, j of (z_j - zhat_j)^2,
    zhat'' = z_ref'' + K_d (z_ref' - zhat') + K_p (z_ref - zhat)

The paper minimises with Powell's method (xtol = ftol = 1e-8, Table 3) through an ODE solver. The loop is
linear: `gains_from_trajectories` steps it exactly and minimises with Gauss-Newton, optionally with integral,
lag, and an offset for each vehicle and flight (battery, mass). These are best for any gains in closed form:

    zhat = zhat(b = 0) + b s,   b = sum (z - zhat(b = 0)) s / sum s^2

with s the response to a unit offset. `is_better` is an F test between two such fits.

Trajectories identify gains only under excitation: an initial error, or an offset. A step of the reference or
downwash is none, as zhat does not have them. Only the whole loop is identifiable: a thrust lag T lowers the
identified K_d by K_p T.

In flight the residual r is the loop's own response to gusts, noise and what the loop leaves out, as slow as
the response to the initial error, so it may be proportional to the sensitivity J of zhat. An interval is
therefore at least as wide as r of twice its root mean square s could move the estimate in each stretch,

    half width >= 2 s sqrt(sum over stretches of (sum over t of |J (J' J)^-1|)^2)

Hovering dilutes s, and the share of the deviation that the loop explains. So s is at least that of the rows
whose |zhat - z_ref| is above 5 times the residual of all rows, and the share is that of these rows.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import least_squares, minimize
from scipy.special import fdtrc

from q2q_model.identification.gains.altitude_record import AltitudeRecord, flight_numbers
from q2q_model.identification.gains.huber_regression import SIGNIFICANCE
from q2q_model.identification.gains.impulse_response import free_response, offset_response
from q2q_model.identification.statistics.intervals import (
    Interval,
    Stretch,
    around,
    cluster_rows,
    half_widths,
    least_squares_rows,
)
from q2q_model.signals.values import Array, Mask
from q2q_model.vehicle.altitude_loop import AltitudeLoop

TOLERANCE = 1e-8
"""xtol and ftol of Table 3."""
BLOCK = 5.0
"""Minimum length of a cluster of residuals [s]: two thirds of the loop's period."""
FORBIDDEN = 1e12
"""Loss of negative gains [m^2]."""
LOW = {"k_p": 1e-3, "k_d": 0.0, "k_i": 0.0, "lag": 1e-3}
HIGH = {"k_p": 200.0, "k_d": 50.0, "k_i": 100.0, "lag": 0.5}
START = {"k_p": 1.0, "k_d": 0.5, "k_i": 0.01, "lag": 0.05}
"""Bounds and first values of the search [1/s^2], [1/s], [1/s^3], [s]: far around those of small vehicles."""
NO_RESIDUAL = 1e-300
"""Squares in place of 0 where a fit leaves no residual [m^2]."""
SIGMAS = 2.0
"""Bound of a residual over its root mean square [-]: 95 % of a normal."""
ABOVE = 5.0
"""Response of a loop over the root mean square residual above which a row shows it [-]: noise never is."""
OFFSET, INTEGRAL = "offset", "k_i"
"""Options of an offset for each vehicle of each flight, and of an integral."""


@dataclass(frozen=True, slots=True)
class TrajectoryGains:
    """Loop fitted to trajectories."""

    loop: AltitudeLoop
    """Its offset is the mean of the vehicles'."""
    intervals: tuple[tuple[str, Interval], ...]
    """Of the gains and the lag."""
    mse: tuple[Array, ...]
    """Mean square error of each vehicle [m^2], (n,) of every flight."""
    rms: float
    """Root mean square error of all rows of all vehicles [m]."""
    rows: float
    """Effective number of independent residuals."""
    terms: int = 2
    """Number of fitted parameters, offsets included."""
    explained: float = float("nan")
    """Share of the mean square deviation from the references that the loop explains [-], in the rows that
    show it; 0 if none does."""


def gains_from_trajectories(
    records: Sequence[AltitudeRecord], options: Sequence[str] = (), lag: float = 0.0
) -> TrajectoryGains:
    """Return the loop fitted to altitudes.

    Args:
        records: altitudes of the flights.
        options: what is fitted besides K_p and K_d, among offset, k_i and lag.
        lag: time constant of the thrust [s], if it is not fitted.
    """
    names = ["k_p", "k_d", *(name for name in options if name != OFFSET)]
    bounds = (np.array([LOW[name] for name in names]), np.array([HIGH[name] for name in names]))
    start = np.array([START[name] for name in names])

    def fitted(x: Array) -> list[tuple[Array, Array]]:
        loop = _loop(names, x, lag)
        return [_fitted(record, loop, shifted=OFFSET in options) for record in records]

    found = least_squares(
        lambda x: _flat([residual for residual, _ in fitted(x)]),
        start,
        bounds=bounds,
        x_scale=np.maximum(np.abs(start), 0.05),
    )
    residuals, offsets = zip(*fitted(found.x), strict=True)
    stretches = [
        Stretch(k, record.t, one)
        for k, record, residual in zip(flight_numbers(records), records, residuals, strict=True)
        for one in residual.T
    ]
    rows = least_squares_rows(found.jac, found.fun, cluster_rows(stretches, BLOCK))
    showing = _showing(records, residuals)
    rms = max(_rms(residuals), _rms([found.fun[showing]]) if showing.any() else 0.0)
    wide = np.maximum(half_widths(rows), _widest(found.jac, rms, stretches))
    spread = around(found.x, wide, (np.minimum(bounds[0], 0.0), bounds[1]))
    rho = _correlation(residuals)
    each = np.concatenate(offsets)
    return TrajectoryGains(
        loop=replace(_loop(names, found.x, lag), offset=float(each.mean())),
        intervals=tuple(zip(names, spread, strict=True)),
        mse=tuple((residual**2).mean(axis=0) for residual in residuals),
        rms=_rms(residuals),
        rows=found.fun.size * (1.0 - rho) / (1.0 + rho),
        terms=len(names) + (each.size if OFFSET in options else 0),
        explained=_explained(records, residuals, showing),
    )


def gains_by_powell(records: Sequence[AltitudeRecord]) -> TrajectoryGains:
    """Return the paper's fit: Powell's method through an adaptive ODE solver, K_p and K_d only."""

    def loss(x: Array) -> float:
        if (x < 0.0).any():
            return FORBIDDEN
        return sum(float((_solved(record, x) ** 2).sum()) for record in records)

    found = minimize(
        loss, [START["k_p"], START["k_d"]], method="Powell", options={"xtol": TOLERANCE, "ftol": TOLERANCE}
    )
    loop = _loop(["k_p", "k_d"], found.x)
    unknown = tuple(
        (name, Interval(float(x), float("nan"), float("nan")))
        for name, x in zip(("k_p", "k_d"), found.x, strict=True)
    )
    residuals = [_solved(record, found.x) for record in records]
    mse = tuple((residual**2).mean(axis=0) for residual in residuals)
    return TrajectoryGains(loop=loop, intervals=unknown, mse=mse, rms=_rms(residuals), rows=float("nan"))


def is_better(more: TrajectoryGains, less: TrajectoryGains) -> bool:
    """Return whether an F test finds the extra terms of `more` significant."""
    extra = more.terms - less.terms
    freedom = max(more.rows - more.terms, 1.0)
    ratio = (less.rms**2 - more.rms**2) / max(more.rms**2, NO_RESIDUAL) * freedom / extra
    return bool(fdtrc(extra, freedom, max(ratio, 0.0)) < SIGNIFICANCE)


def _fitted(record: AltitudeRecord, loop: AltitudeLoop, *, shifted: bool) -> tuple[Array, Array]:
    """Return z - zhat [m], (T, n), and the offsets of the vehicles [m/s^2], (n,): 0 if not `shifted`."""
    residual = record.deviation - free_response(loop, record.dt, record.start, record.jerk)
    if not shifted:
        return residual, np.zeros(residual.shape[1])
    response = offset_response(record, loop)
    offset = (response * residual).sum(axis=0) / (response**2).sum()
    return residual - offset * response, offset


def _solved(record: AltitudeRecord, gains: Array) -> Array:
    """Return z - zhat [m], (T, n), by an adaptive solver with default tolerances."""
    k_p, k_d = gains
    t, n = record.t, len(record.names)

    def rate(when: float, state: Array) -> Array:
        ref = np.stack([[np.interp(when, t, record.ref[:, i, k]) for i in range(n)] for k in range(3)])
        z, v = state[:n], state[n:]
        return np.concatenate((v, ref[2] + k_d * (ref[1] - v) + k_p * (ref[0] - z)))

    start = np.concatenate((record.pos[0, :, 2], record.vel[0, :, 2]))
    solved = solve_ivp(rate, (t[0], t[-1]), start, t_eval=t)
    return np.asarray(record.pos[..., 2] - solved.y[:n].T)


def _widest(jacobian: Array, rms: float, stretches: Sequence[Stretch]) -> Array:
    """Return how far a bounded residual could move each parameter, (p,); infinite without information."""
    scale = np.linalg.norm(jacobian, axis=0)
    if not (scale > 0.0).all():
        return np.full(scale.size, np.inf)
    moves = np.abs(np.linalg.pinv(jacobian / scale)) / scale[:, None]  # (p, rows)
    begins = np.cumsum([0, *(one.t.size for one in stretches[:-1])])
    return np.asarray(SIGMAS * rms * np.linalg.norm(np.add.reduceat(moves, begins, axis=1), axis=1))


def _showing(records: Sequence[AltitudeRecord], residuals: Sequence[Array]) -> Mask:
    """Return the rows in which the loop's own response is above the residuals, (rows,)."""
    responses = _flat([record.deviation - one for record, one in zip(records, residuals, strict=True)])
    return np.asarray(np.abs(responses) > ABOVE * _rms(residuals))


def _explained(records: Sequence[AltitudeRecord], residuals: Sequence[Array], showing: Mask) -> float:
    flown = _flat([record.deviation for record in records])[showing]
    return 1.0 - (_rms([_flat(residuals)[showing]]) / _rms([flown])) ** 2 if showing.any() else 0.0


def _flat(each: Sequence[Array]) -> Array:
    """Return values of all records, vehicle after vehicle, (rows,)."""
    return np.concatenate([one.T.ravel() for one in each])


def _loop(names: Sequence[str], x: Array, lag: float = 0.0) -> AltitudeLoop:
    values = {"k_p": 0.0, "k_d": 0.0, "lag": lag} | dict(zip(names, (float(v) for v in x), strict=True))
    return AltitudeLoop(**values)


def _rms(residuals: Sequence[Array]) -> float:
    return float(np.sqrt(np.mean(np.concatenate([residual.ravel() for residual in residuals]) ** 2)))


def _correlation(residuals: Sequence[Array]) -> float:
    along = sum(float((residual[1:] * residual[:-1]).sum()) for residual in residuals)
    return float(
        np.clip(
            along / max(sum(float((residual**2).sum()) for residual in residuals), NO_RESIDUAL), 0.0, 0.9999
        )
    )
