"""Gains of the altitude loop by regression of the controller's commands on its inputs.

    U1 b_z / m - g - z_ref'' = K_p (z_ref - z) + K_d (z_ref' - z') + K_i xi - c eta_ff + b
                               + c_v z_ref' + c_a z_ref''

Each tick gives one row, linear in the gains; Huber weights suppress rows in which a limit of the thrust was
active, and those at the limit of a velocity setpoint are left out where its differences are z_ref''
(velocity_limit). The offset b is separate for each vehicle and flight (battery, mass). Terms beyond K_p and
K_d are kept only if an F test finds them significant. Correlated rows reduce the effective number of rows to
n (1 - rho) / (1 + rho), with rho the correlation of successive residuals (huber_regression).

U1 b_z is what the controller wants along z if it divides by the tilt. One that commands the size of its force
(q2q_sim.experiments.validation.recorded_law) wants it along another tilt than that of the vehicle, b. On the
recorded flights this moves K_p by up to 2 % and K_d by 1 %, more than the ends of their intervals.

Residuals must not come back with the motion: one that lasts for some ticks (noise of the controller's own
estimate) moves the vehicle, and with it the inputs of its later ticks. Gains are too small then, and
intervals do not say so: by 1.4 % (K_p) and 2.5 % (K_d) in simulated flights with a residual of 0.1 m/s^2
that lasts for 30 ms, next to gusts of 0.2 m/s^2. The inputs of 50 ms before, as instruments, remove this.
They move the gains of the 23 recorded flights within a third of their intervals, by up to 2.4 %, and K_d
down in 17 of them, against this bias, so they are not used.

c_v and c_a are tried where the rates of references are those of a fit to their positions: a controller may
have none (c_v = -K_d, c_a = -1), as has the firmware that is sent positions. Else they are 0.

| symbol | name | meaning [unit] |
|---|---|---|
| K_p K_d b K_i | loop | see q2q_model.vehicle.altitude_loop |
| xi | | integral of z_ref - z [m s] |
| c | | share of the downwash eta_ff that the controller compensates [-] |
| c_v c_a | of_rates | use of the rates of references next to the loop [1/s], [-] |
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from q2q_model.counted import counted
from q2q_model.identification.gains.altitude_record import AltitudeRecord, flight_numbers
from q2q_model.identification.gains.huber_regression import (
    RESOLUTION,
    SIGNIFICANCE,
    huber_fit,
    robust_deviation,
    significance,
)
from q2q_model.identification.gains.velocity_limit import at_velocity_limit
from q2q_model.identification.statistics.intervals import (
    EstimatingRows,
    Interval,
    Stretch,
    cluster_rows,
    intervals,
)
from q2q_model.signals.values import Array, Mask
from q2q_model.vehicle.altitude_loop import AltitudeLoop

FEWEST_ROWS = 200
"""Fewest rows: 2 s at 100 Hz."""
BLOCK = 1.0
"""Minimum length of a cluster of residuals [s]."""
K_P, K_D, INTEGRAL, FEED_FORWARD, REF_VEL, REF_ACC, OFFSET = range(7)
"""Terms of the equation; OFFSET is one column for each vehicle of each flight."""


@dataclass(frozen=True, slots=True)
class GainFit:
    """Fitted loop, its intervals and its significant terms."""

    loop: AltitudeLoop
    k_p: Interval
    k_d: Interval
    needs_offset: bool
    needs_integral: bool
    rms: float
    """Standard deviation of the residual: [m/s^2] from commands, [m] from trajectories."""
    from_commands: bool = True
    compensated: float = 0.0
    """c [-]; 0 if not found from commands."""
    of_rates: tuple[float, float] = (0.0, 0.0)
    """c_v [1/s] and c_a [-]."""
    limited: float = 0.0
    """Share of the rows that was left out, as their velocity setpoint is at its limit [-]."""
    alike: bool = True
    """Whether the flights, one by one, have the same gains."""

    @property
    def holds(self) -> bool:
        """Return whether the gains of all flights lead a vehicle to its reference.

        Those of trajectories must show it by their intervals.
        """
        shown = self.from_commands or (self.k_p.is_positive and self.k_d.is_positive)
        return self.alike and shown and self.loop.k_p > 0.0 and self.loop.k_d > 0.0


@dataclass(frozen=True, slots=True)
class _Equation:
    """Regression of all vehicles of all flights."""

    target: Array
    columns: Array
    """K_P to REF_ACC, (rows, 6)."""
    group: Array
    """Number of record and vehicle, (rows,)."""
    flight: Array
    """Number of the flight, (rows,)."""
    t: Array
    """[s], (rows,), ascending within a group."""
    limited: Mask
    """Whether z_ref'' is the difference of a velocity setpoint at its limit, (rows,)."""


def gains_from_commands(records: Sequence[AltitudeRecord]) -> GainFit:
    """Return the gains of the controller.

    Raises:
        ValueError: too few rows with commands.
    """
    whole = _stacked(records)
    system = _without_limited(whole)
    if system.target.size < FEWEST_ROWS:
        flights = len({record.name for record in records})  # a record may be a piece of one
        raise ValueError(
            f"{counted(system.target.size, 'row')} with thrust commands in "
            f"{counted(flights, 'flight')}, at references with rates; must be at least {FEWEST_ROWS}: "
            "record the topics command and reference, or fit the gains to trajectories"
        )
    terms = [K_P, K_D, INTEGRAL, FEED_FORWARD, REF_VEL, REF_ACC, OFFSET]
    for term in (REF_ACC, REF_VEL, FEED_FORWARD, INTEGRAL, OFFSET):
        if not _is_needed(system, terms, term):
            terms.remove(term)
    design = _design(system, terms)
    value, weight = huber_fit(design, system.target)
    residual = system.target - design @ value
    gains = [term for term in terms if term != OFFSET]
    spread = intervals(value[: len(gains)], _rows(system, terms, residual, weight))
    found = dict(zip(gains, spread, strict=True))
    loop = AltitudeLoop(
        k_p=found[K_P].value,
        k_d=found[K_D].value,
        k_i=found[INTEGRAL].value if INTEGRAL in found else 0.0,
        offset=float(value[len(found) :].mean()) if OFFSET in terms else 0.0,
    )
    return GainFit(
        loop=loop,
        k_p=found[K_P],
        k_d=found[K_D],
        needs_offset=OFFSET in terms,
        needs_integral=INTEGRAL in terms,
        rms=robust_deviation(residual),
        compensated=found[FEED_FORWARD].value if FEED_FORWARD in found else 0.0,
        of_rates=(
            found[REF_VEL].value if REF_VEL in found else 0.0,
            found[REF_ACC].value if REF_ACC in found else 0.0,
        ),
        limited=1.0 - system.target.size / whole.target.size,
    )


def _stacked(records: Sequence[AltitudeRecord]) -> _Equation:
    each = [
        (record, i, flight)
        for record, flight in zip(records, flight_numbers(records), strict=True)
        for i in range(len(record.names))
    ]
    parts = [_equation(record, i, group, flight) for group, (record, i, flight) in enumerate(each)]
    stacked = {
        one.name: np.concatenate([getattr(part, one.name) for part in parts]) for one in fields(_Equation)
    }
    return _Equation(**stacked)


def _without_limited(system: _Equation) -> _Equation:
    """Return the rows whose velocity setpoint is not at its limit; all if those are few, as in a climb."""
    rows = ~system.limited
    if rows.sum() < FEWEST_ROWS:
        return system
    return _Equation(**{one.name: getattr(system, one.name)[rows] for one in fields(system)})


def _equation(record: AltitudeRecord, i: int, group: int, flight: int) -> _Equation:
    error = -record.deviation[:, i]
    rate = record.ref[:, i, 1] - record.vel[:, i, 2]
    integral = np.cumsum(error) * record.dt
    feed_forward = np.where(np.isfinite(record.feed_forward[:, i]), record.feed_forward[:, i], 0.0)
    rates = record.ref[:, i, 1:] * record.rates_fitted  # (T, 2)
    columns = np.column_stack([error, rate, integral - integral.mean(), -feed_forward, rates])
    target = record.commanded_acc[:, i] - record.ref[:, i, 2]
    known = np.isfinite(target)
    t, limited = record.t[known], at_velocity_limit(record.ref[:, i, 1])[known] & record.acc_differentiated
    groups, flights = np.full(t.size, group), np.full(t.size, flight)
    return _Equation(target[known], columns[known], groups, flights, t, limited)


def _rows(system: _Equation, terms: Sequence[int], residual: Array, weight: Array) -> EstimatingRows:
    """Return the estimating rows of the gains, with offsets eliminated by the mean of each group.

    Huber's psi is the weighted residual; its slope is 1 for rows of full weight, else 0.
    """
    columns = system.columns[:, [term for term in terms if term != OFFSET]].copy()
    slope = (weight == 1.0).astype(np.float64)
    psi = weight * np.copysign(np.maximum(np.abs(residual), RESOLUTION), residual)
    stretches = []
    for group in np.unique(system.group):
        own = system.group == group
        if OFFSET in terms:
            columns[own] -= slope[own] @ columns[own] / max(slope[own].sum(), 1.0)
        stretches.append(Stretch(int(system.flight[own][0]), system.t[own], psi[own]))
    return EstimatingRows(columns, psi, slope, cluster_rows(stretches, BLOCK))


def _design(system: _Equation, terms: Sequence[int]) -> Array:
    """Return the columns of `terms` in order, those of the offsets last."""
    plain = system.columns[:, [term for term in terms if term != OFFSET]]
    if OFFSET not in terms:
        return plain
    own = system.group[:, None] == np.unique(system.group)
    return np.concatenate((plain, own.astype(np.float64)), axis=1)


def _is_needed(system: _Equation, terms: list[int], term: int) -> bool:
    """Return whether an F test finds `term` significant."""
    if term != OFFSET and np.ptp(system.columns[:, term]) == 0.0:
        return False
    whole, less = _design(system, terms), _design(system, [other for other in terms if other != term])
    return significance(whole, less, system.target) < SIGNIFICANCE
