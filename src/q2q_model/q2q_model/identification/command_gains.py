"""Read the gains of the altitude loop where it is made: between what the controller saw and asked for.

    U1 b_z / m - g - z_ref'' = K_p (z_ref - z) + K_d (z_ref' - z') + b + K_i xi - c eta_told

One row a tick, linear in the gains, so least squares is exact; Huber weights keep rows out in which a limit
cut in. Terms beyond K_p and K_d enter only where an F test asks for them: does the sum of squares fall by
more than chance? Rows that err together count as fewer, n (1 - rho) / (1 + rho), rho the residual's
correlation from one row to the next.

| symbol | name | meaning [unit] |
|---|---|---|
| K_p K_d b K_i | loop | see q2q_model.identification.altitude_loop |
| xi | | integral of z_ref - z [m s] |
| c | | share of the told draft that the controller takes off [-] |
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import fdtrc

from q2q_model.identification.altitude_loop import AltitudeLoop
from q2q_model.identification.altitude_record import AltitudeRecord
from q2q_model.identification.interval import Interval, intervals, sandwich
from q2q_model.signals import Array

FEWEST = 200
"""Rows: 2 s at 100 Hz."""
NEEDED = 0.01
"""A term is needed when chance alone explains it with less probability than this [-]."""
HUBER = 1.345
"""Spreads beyond which a row weighs less; 95 % efficient for normal errors (Huber 1981)."""
RESOLUTION = 1e-6
"""Acceleration below which no term is worth having and no row can be trusted [m/s^2]: 1e-7 of g."""
ROUNDS = 10
"""Of reweighting: each shrinks what is left by more than half."""
BLOCK = 1.0
"""Length of a block of dependent errors [s]."""

K_P, K_D, OFFSET, INTEGRAL, TOLD = range(5)
"""Columns of the equation."""


@dataclass(frozen=True, slots=True)
class GainFit:
    """Hold a fitted loop, its intervals, and which terms it needs."""

    loop: AltitudeLoop
    k_p: Interval
    k_d: Interval
    needs_offset: bool
    needs_integral: bool
    rms: float
    """Spread of the residual: acceleration [m/s^2] from commands, altitude [m] from trajectories."""
    from_commands: bool = True


@dataclass(frozen=True, slots=True)
class _Equation:
    target: Array
    columns: Array
    block: Array


def gains_from_commands(records: Sequence[AltitudeRecord]) -> GainFit:
    """Return the gains that flew.

    Raises:
        ValueError: too few rows with commands.
    """
    system = _stacked(records)
    if system.target.size < FEWEST:
        raise ValueError(
            f"{system.target.size} rows with thrust commands in {len(records)} flights, {FEWEST} needed: "
            "record the topic command, or fit the gains to trajectories"
        )
    used = [K_P, K_D]
    for term in (TOLD, OFFSET, INTEGRAL):
        if _is_needed(system, used, term):
            used.append(term)
    value, weight = _robust(system, used)
    residual = system.target - system.columns[:, used] @ value
    root = np.sqrt(weight)
    seen = np.copysign(np.maximum(np.abs(residual), RESOLUTION), residual)
    covariance = sandwich(root[:, None] * system.columns[:, used], root * seen, system.block)
    found = dict(zip(used, intervals(value, covariance), strict=True))
    loop = AltitudeLoop(
        k_p=found[K_P].value,
        k_d=found[K_D].value,
        k_i=found[INTEGRAL].value if INTEGRAL in found else 0.0,
        offset=found[OFFSET].value if OFFSET in found else 0.0,
    )
    return GainFit(
        loop=loop,
        k_p=found[K_P],
        k_d=found[K_D],
        needs_offset=OFFSET in found,
        needs_integral=INTEGRAL in found,
        rms=_spread(residual),
    )


def _stacked(records: Sequence[AltitudeRecord]) -> _Equation:
    parts = [_equation(record, i, k) for k, record in enumerate(records) for i in range(len(record.names))]
    return _Equation(
        target=np.concatenate([part.target for part in parts]),
        columns=np.concatenate([part.columns for part in parts]),
        block=np.concatenate([part.block for part in parts]),
    )


def _equation(record: AltitudeRecord, i: int, flight: int) -> _Equation:
    error = -record.deviation[:, i]
    rate = record.ref[:, i, 1] - record.vel[:, i, 2]
    integral = np.cumsum(error) * record.dt
    told = np.where(np.isfinite(record.feed_forward[:, i]), record.feed_forward[:, i], 0.0)
    columns = np.stack([error, rate, np.ones_like(error), integral - integral.mean(), -told], axis=1)
    target = record.lift[:, i] - record.ref[:, i, 2]
    known = np.isfinite(target)
    block = 1e6 * flight + 1e3 * i + np.floor(record.t / BLOCK)
    return _Equation(target[known], columns[known], block[known])


def _is_needed(system: _Equation, used: list[int], term: int) -> bool:
    """Return whether `term` lowers the weighted sum of squares by more than chance."""
    if np.ptp(system.columns[:, term]) == 0.0 and term != OFFSET:
        return False
    _, weight = _robust(system, used)
    less, more = (_squares(system, terms, weight) for terms in (used, [*used, term]))
    rho = _correlation(system, used, weight)
    rows = weight.sum() * (1.0 - rho) / (1.0 + rho)
    freedom = max(rows - len(used) - 1, 1.0)
    ratio = (less - more) / max(more, rows * RESOLUTION**2) * freedom
    return bool(fdtrc(1, freedom, max(ratio, 0.0)) < NEEDED)


def _robust(system: _Equation, used: list[int]) -> tuple[Array, Array]:
    """Return the parameters and the Huber weight of every row, by reweighting."""
    weight = np.ones_like(system.target)
    for _ in range(ROUNDS):
        root = np.sqrt(weight)
        columns, target = root[:, None] * system.columns[:, used], root * system.target
        value: Array = np.linalg.lstsq(columns, target, rcond=None)[0].astype(np.float64)
        residual = np.abs(system.target - system.columns[:, used] @ value)
        weight = np.minimum(1.0, HUBER * _spread(residual) / np.maximum(residual, 1e-12))
    return value, weight


def _spread(residual: Array) -> float:
    """Return the standard deviation by the median of absolutes; 1.4826 makes it that of a normal."""
    return max(1.4826 * float(np.median(np.abs(residual))), RESOLUTION)


def _squares(system: _Equation, terms: list[int], weight: Array) -> float:
    residual = _weighted_residual(system, terms, weight)
    return float(residual @ residual)


def _correlation(system: _Equation, terms: list[int], weight: Array) -> float:
    residual = _weighted_residual(system, terms, weight)
    total = float(residual @ residual)
    return float(np.clip(float(residual[1:] @ residual[:-1]) / max(total, 1e-300), 0.0, 0.999))


def _weighted_residual(system: _Equation, terms: list[int], weight: Array) -> Array:
    root = np.sqrt(weight)
    columns, target = root[:, None] * system.columns[:, terms], root * system.target
    value, *_ = np.linalg.lstsq(columns, target, rcond=None)
    return np.asarray(target - columns @ value)
