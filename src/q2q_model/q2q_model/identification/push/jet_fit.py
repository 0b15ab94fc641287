"""Least-squares fit of the jet to measured downwash (push_samples) or to altitudes (14).

Fitted are strength, decay, width, spread, upper ratio, and slowness 1 / travel_speed; of a loaded form also
the share of velocity left by the still air, loading and absorption. The form of the decay and the share of
velocity and slope that the air keeps are given. The residuals are

    pushes:     y - eta                        on exposed and upper rows
    altitudes:  z - z_free - (h * eta)         every tenth tick, as the loop is much slower

The loss on pushes is soft_l1, with z = (r / s)^2: psi = r (1 + z)^-1/2, psi' = (1 + z)^-3/2.
Intervals allow for correlation within a flight or a stretch of it (q2q_model.identification.intervals).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares, minimize

from q2q_model.downwash.jet import Jet
from q2q_model.identification.gains.altitude_record import AltitudeRecord, flight_numbers
from q2q_model.identification.gains.impulse_response import downwash_response, undisturbed
from q2q_model.identification.intervals import (
    EstimatingRows,
    Interval,
    Stretch,
    cluster_rows,
    intervals,
    least_squares_rows,
)
from q2q_model.identification.push.along_flight import FlownRows, Motion, VehicleTicks, eta_on_vehicle
from q2q_model.identification.push.push_samples import PushSamples
from q2q_model.signals.values import Array
from q2q_model.vehicle.altitude_loop import AltitudeLoop

THINNING = 10
"""Ticks per residual: 10 Hz for a loop of 0.9 rad/s."""
BLOCK = 0.5
"""Minimum length of a cluster of residuals [s]: five times the passage of a jet of 0.1 m at 1 m/s."""
Z95 = 1.96
"""Standard deviations that contain 95 % of a normal."""
MOST_STD = 10.0
"""Largest std_floor [m/s^2] and relative_std [-] of a jet."""
FASTEST = 500.0
"""Travel speed above which delay is negligible [m/s]: a tenth of a tick over half a metre."""
TURBULENT = 0.25
"""Residual from which soft_l1 is linear [m/s^2]: the spread of y in clear air on real flights is 0.2 to 0.3;
larger residuals are turbulence."""


@dataclass(frozen=True, slots=True)
class JetForm:
    """Structure of a jet, chosen before fitting."""

    decay: str = "exponential"
    carried: float = 1.0
    delayed: bool = True
    spreading: bool = True
    loaded: bool = False
    """Whether velocity share, loading and, from flights of three or more, absorption are fitted."""


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

    stacked = any(one.motion.pos.shape[1] > 2 for one in samples)  # one vehicle may be between two
    fit = _fit(residuals, form, solved, "soft_l1", stacked=stacked)
    floor, share = _affine(*_magnitudes(fit.jet, samples))
    return replace(fit, jet=replace(fit.jet, std_floor=floor, relative_std=share))


def fit_to_altitudes(
    records: Sequence[AltitudeRecord], loop: AltitudeLoop, form: JetForm, solved: Jet | None = None
) -> JetFit:
    """Return the jet fitted to altitudes under a closed loop; `solved` as in fit_to_pushes."""
    motions, numbers = [Motion(one.t, one.pos, one.vel, one.axis) for one in records], flight_numbers(records)
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
    names, start = _free_parameters(form, stacked=stacked)
    low, high = (np.array([_BOUNDS[name][side] for name in names]) for side in (0, 1))
    if solved is not None:
        start = np.clip(_values(solved, names), low, high)
    found = least_squares(
        lambda x: np.concatenate([one.residual for one in residuals(_jet(form, names, x))]),
        start,
        bounds=(low, high),
        x_scale=np.array([_SCALES[name] for name in names]),
        diff_step=1e-4,  # the residual is not smooth where a pair enters the reach
        xtol=1e-5,
        ftol=1e-7,
        max_nfev=25 if solved is None else 1,  # one evaluation, and its Jacobian
        loss=loss,
        f_scale=TURBULENT,
    )
    jet = _jet(form, names, found.x)
    cluster = cluster_rows(residuals(jet), BLOCK)
    rows = (_soft_l1_rows if loss == "soft_l1" else least_squares_rows)(found.jac, found.fun, cluster)
    spread = tuple(zip(names, intervals(found.x, rows, (low, high)), strict=True))
    return JetFit(jet=jet, intervals=spread, mse=float(np.mean(found.fun**2)))


def _soft_l1_rows(jacobian: Array, residual: Array, cluster: Array) -> EstimatingRows:
    """Return the rows of a fit by soft_l1, whose `jacobian` SciPy has multiplied by sqrt(psi')."""
    spread = 1.0 + (residual / TURBULENT) ** 2
    slope = spread**-1.5
    return EstimatingRows(jacobian / np.sqrt(slope)[:, None], residual / np.sqrt(spread), slope, cluster)


_BOUNDS = {
    "strength": (-5.0, 15.0),
    "decay_rate": (-2.0, 10.0),
    "virtual_origin": (0.02, 5.0),
    "width": (0.015, 0.4),
    "spread": (0.0, 0.4),
    "upper_ratio": (-0.8, 0.8),
    "slowness": (0.0, 0.8),
    "velocity_share": (0.0, 1.0),
    "loading": (0.0, 2.0),
    "absorption": (0.0, 4.0),
}
_SCALES = {
    "strength": 1.0,
    "decay_rate": 1.0,
    "virtual_origin": 0.3,
    "width": 0.05,
    "spread": 0.1,
    "upper_ratio": 0.2,
    "slowness": 0.2,
    "velocity_share": 0.3,
    "loading": 0.5,
    "absorption": 1.0,
}


def _free_parameters(form: JetForm, *, stacked: bool) -> tuple[list[str], Array]:
    start = {"strength": 1.5, "width": 0.07, "upper_ratio": 0.02}
    start |= {"decay_rate": 1.0} if form.decay == "exponential" else {"virtual_origin": 0.5}
    start |= {"spread": 0.05} if form.spreading else {}
    start |= {"slowness": 0.15} if form.delayed else {}
    start |= {"velocity_share": 0.8, "loading": 0.3} if form.loaded else {}
    start |= {"absorption": 0.5} if form.loaded and stacked else {}
    return list(start), np.array(list(start.values()))


def _jet(form: JetForm, names: Sequence[str], x: Array) -> Jet:
    values = dict(zip(names, (float(v) for v in x), strict=True))
    slowness = values.pop("slowness", 0.0)
    return Jet(
        reference_gap=0.4,
        decay=form.decay,
        carried=form.carried,
        travel_speed=1.0 / slowness if slowness * FASTEST > 1.0 else 0.0,
        range=1.5,
        **({"spread": 0.0} | values),
    )


def _values(jet: Jet, names: Sequence[str]) -> Array:
    """Return a jet's fitted parameters, (p,); the inverse of `_jet`."""
    slowness = 1.0 / jet.travel_speed if jet.travel_speed > 0.0 else 0.0
    return np.array([slowness if name == "slowness" else getattr(jet, name) for name in names])


def with_held_out_deviation(jet: Jet, samples: Sequence[PushSamples], form: JetForm) -> Jet:
    """Return a jet whose deviation comes from cross-validation over two halves of the flights.

    A single flight is split at the median time of its exposed rows. Without exposed rows in both halves, the
    jet keeps the deviation of its training residuals.
    """
    halves = _halves(samples)
    if not all(any(one.exposed.any() for one in half) for half in halves):
        return jet
    parts = [_magnitudes(fit_to_pushes(halves[1 - k], form).jet, halves[k]) for k in (0, 1)]
    floor, share = _affine(*(np.concatenate(some) for some in zip(*parts, strict=True)))
    return replace(jet, std_floor=floor, relative_std=share)


def _halves(samples: Sequence[PushSamples]) -> list[list[PushSamples]]:
    """Return the samples of each half of the flights, or of the only flight with exposed rows."""
    flights = list(dict.fromkeys(one.flight for one in samples if one.exposed.any()))
    if len(flights) > 1:
        return [[one for one in samples if one.flight in flights[k::2]] for k in (0, 1)]
    own = [one for one in samples if one.flight in flights]
    middle = float(np.median(np.concatenate([one.motion.t[one.exposed] for one in own]))) if own else 0.0
    early = [one.motion.t < middle for one in own]
    return [
        [
            replace(one, exposed=one.exposed & rows, upper=one.upper & rows)
            for one, rows in zip(own, half, strict=True)
        ]
        for half in (early, [~rows for rows in early])
    ]


def _magnitudes(jet: Jet, samples: Sequence[PushSamples]) -> tuple[Array, Array]:
    """Return |eta| and |y - eta| on exposed rows, (k,)."""
    pushes, errors = [np.empty(0)], [np.empty(0)]
    for one in samples:
        rows = np.nonzero(one.exposed)[0]
        eta = eta_on_vehicle(jet, one.motion, one.vehicle, rows)[:, 2]
        pushes.append(np.abs(eta))
        errors.append(np.abs(one.y[rows] - eta))
    return np.concatenate(pushes), np.concatenate(errors)


def _affine(push: Array, error: Array) -> tuple[float, float]:
    """Return floor [m/s^2] and share of the deviation floor + share |eta| of residuals.

    Both are those of `deviation_of`, scaled so that 95 % of the rows lie within 1.96 deviations, because the
    tails are not normal.
    """
    if push.size == 0:
        return 0.0, 0.0
    floor, share = deviation_of(push, error)
    wide = float(np.quantile(error / (floor + share * push), 0.95)) / Z95
    return float(min(wide * floor, MOST_STD)), float(min(wide * share, MOST_STD))


def deviation_of(push: Array, error: Array, noise: float = 0.0) -> tuple[float, float]:
    """Return floor [m/s^2] and share, (floor + share |eta|), of maximum likelihood for a normal.

    The variance of the errors is the square of that deviation, plus that of a noise.

    Args:
        push: |eta| [m/s^2], (k,), k at least 1.
        error: |y - eta| [m/s^2], (k,).
        noise: its standard deviation [m/s^2].
    """

    def negative_log_likelihood(x: Array) -> float:
        std = np.hypot(np.exp(x[0]) + np.exp(x[1]) * push, noise)
        return float(np.sum(np.log(std) + 0.5 * (error / std) ** 2))

    first = np.log([max(float(np.sqrt(np.mean(error**2))), 1e-6), 0.1])
    floor, share = np.exp(minimize(negative_log_likelihood, first, method="Nelder-Mead").x)
    return float(floor), float(share)
