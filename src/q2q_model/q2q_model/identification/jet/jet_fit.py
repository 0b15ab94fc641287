"""Least-squares fit of the jet to measured downwash (push_samples) or to altitudes (14).

The free parameters of a JetForm are fitted. The residuals are

    pushes:     y - eta                        on exposed and upper rows
    altitudes:  z - z_free - (h * eta)         every tenth tick, as the loop is much slower

The loss on pushes is soft_l1, with z = (r / s)^2: psi = r (1 + z)^-1/2, psi' = (1 + z)^-3/2.
Intervals allow for correlation within a flight or a stretch of it
(q2q_model.identification.statistics.intervals).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares

from q2q_model.downwash.jet import Jet
from q2q_model.identification.gains.altitude_record import AltitudeRecord, flight_numbers
from q2q_model.identification.gains.impulse_response import downwash_response, undisturbed
from q2q_model.identification.jet.jet_deviation import affine_deviation, pushes_and_errors
from q2q_model.identification.jet.jet_form import (
    FREE_PARAMETERS,
    JetForm,
    free_names,
    jet_of_values,
    values_of_jet,
)
from q2q_model.identification.push.along_flight import FlownRows, VehicleTicks, motion_along
from q2q_model.identification.push.push_samples import PushSamples
from q2q_model.identification.statistics.intervals import (
    EstimatingRows,
    Interval,
    Stretch,
    cluster_rows,
    intervals,
    least_squares_rows,
)
from q2q_model.signals.values import Array
from q2q_model.vehicle.altitude_loop import AltitudeLoop

THINNING = 10
"""Ticks per residual: 10 Hz for a loop of 0.9 rad/s."""
BLOCK = 0.5
"""Minimum length of a cluster of residuals [s]: five times the passage of a jet of 0.1 m at 1 m/s."""
TURBULENT = 0.25
"""Residual from which soft_l1 is linear [m/s^2]: the spread of y in clear air on real flights is 0.2 to 0.3;
larger residuals are turbulence."""


@dataclass(frozen=True, slots=True)
class JetFit:
    """Fitted jet with its intervals."""

    jet: Jet
    intervals: tuple[tuple[str, Interval], ...]
    """Interval of each fitted parameter; slowness is in s/m."""
    mse: float
    """Mean square of the residuals."""


Residuals = Callable[[Jet], list[Stretch]]


def fit_to_pushes(samples: Sequence[PushSamples], form: JetForm, solved: Jet | None = None) -> JetFit:
    """Return the jet fitted to measured pushes of whole flights.

    `solved` is that jet if known already: then only its intervals are computed.
    """
    flights = list(dict.fromkeys(one.flight for one in samples))
    ticks = [np.nonzero(one.exposed | one.upper)[0] for one in samples]
    own = list(zip(samples, ticks, strict=True))
    rows = FlownRows([VehicleTicks(one.motion, one.vehicle, at) for one, at in own])
    y, ends = np.concatenate([one.y[at] for one, at in own]), np.cumsum([at.size for at in ticks])[:-1]
    runs = [(flights.index(one.flight), one.motion.t[at]) for one, at in own]

    def residuals(jet: Jet) -> list[Stretch]:
        missed = np.split(y - rows.eta(jet)[:, 2], ends)
        return [Stretch(*run, part) for run, part in zip(runs, missed, strict=True)]

    fit = _fit(residuals, form, solved, "soft_l1", stacked=may_be_stacked(samples))
    floor, share = affine_deviation(*pushes_and_errors(fit.jet, samples))
    return replace(fit, jet=replace(fit.jet, std_floor=floor, relative_std=share))


def may_be_stacked(samples: Sequence[PushSamples]) -> bool:
    """Return whether some vehicle may be between two others: whether three or more flew together."""
    return any(one.motion.pos.shape[1] > 2 for one in samples)


def fit_to_altitudes(
    records: Sequence[AltitudeRecord], loop: AltitudeLoop, form: JetForm, solved: Jet | None = None
) -> JetFit:
    """Return the jet fitted to altitudes under a closed loop; `solved` as in fit_to_pushes."""
    motions, numbers = [motion_along(one) for one in records], flight_numbers(records)
    flown = [
        FlownRows([VehicleTicks(motion, i, np.arange(motion.t.size)) for i in range(motion.pos.shape[1])])
        for motion in motions
    ]
    targets = [one.deviation - undisturbed(one, loop) for one in records]

    def residuals(jet: Jet) -> list[Stretch]:
        found = []
        for k, record, rows, target in zip(numbers, records, flown, targets, strict=True):
            eta = np.stack(np.split(rows.eta(jet)[:, 2], len(record.names)), axis=1)  # (T, n)
            moved = downwash_response(loop, record.dt, eta)
            missed = (target - moved)[::THINNING].T  # (n, T / 10)
            found += [Stretch(k, record.t[::THINNING], one) for one in missed]
        return found

    return _fit(residuals, form, solved)


def _fit(
    residuals: Residuals, form: JetForm, solved: Jet | None, loss: str = "linear", *, stacked: bool = False
) -> JetFit:
    names = free_names(form, stacked=stacked)
    start, low, high, scale, steps = np.array([FREE_PARAMETERS[name] for name in names]).T
    if solved is not None:
        start = np.clip(values_of_jet(solved, names), low, high)

    def missed(x: Array) -> Array:
        return np.concatenate([one.residual for one in residuals(jet_of_values(form, names, x))])

    found = least_squares(
        missed,
        start,
        jac=lambda x: _jacobian(missed, x, steps, (low, high)),
        bounds=(low, high),
        x_scale=scale,
        xtol=1e-5,
        ftol=1e-7,
        max_nfev=25 if solved is None else 1,  # one evaluation, and its Jacobian
        loss=loss,
        f_scale=TURBULENT,
    )
    jet = jet_of_values(form, names, found.x)
    cluster = cluster_rows(residuals(jet), BLOCK)
    rows = (_soft_l1_rows if loss == "soft_l1" else least_squares_rows)(found.jac, found.fun, cluster)
    spread = tuple(zip(names, intervals(found.x, rows, (low, high)), strict=True))
    return JetFit(jet=jet, intervals=spread, mse=float(np.mean(found.fun**2)))


def _jacobian(
    residual: Callable[[Array], Array], x: Array, steps: Array, bounds: tuple[Array, Array]
) -> Array:
    """Return the derivative of `residual` (m,) by central differences between bounds, (m, p)."""
    low, high = bounds
    columns = []
    for k, step in enumerate(np.diag(steps)):
        ahead, behind = np.minimum(x + step, high), np.maximum(x - step, low)
        columns.append((residual(ahead) - residual(behind)) / (ahead[k] - behind[k]))
    return np.stack(columns, axis=1)


def _soft_l1_rows(jacobian: Array, residual: Array, cluster: Array) -> EstimatingRows:
    """Return the rows of a fit by soft_l1, whose `jacobian` SciPy has multiplied by sqrt(psi')."""
    spread = 1.0 + (residual / TURBULENT) ** 2
    slope = spread**-1.5
    return EstimatingRows(jacobian / np.sqrt(slope)[:, None], residual / np.sqrt(spread), slope, cluster)
