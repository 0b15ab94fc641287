"""Gains of the altitude loop by regression of the controller's commands on its inputs.

    U1 b_z / m - g - z_ref'' = K_p (z_ref - z) + K_d (z_ref' - z') + K_i xi - c eta_ff + b
                               + c_v z_ref' + c_a z_ref''

Each tick gives one row, linear in the gains; Huber weights suppress rows in which a limit of the thrust was
active, and those at the limit of a velocity setpoint are left out where its differences are z_ref''
(velocity_limit). The offset b is separate for each vehicle and flight (battery, mass). Terms beyond K_p and
K_d are kept only if an F test finds them significant. Correlated rows reduce the effective number of rows to
n (1 - rho) / (1 + rho), with rho the correlation of successive residuals (huber_regression). The share c is
that of each flight if they differ by more than APART and an F test finds that significant, as where only some
controllers compensate.

U1 b_z is what the controller wants along z if it divides by the tilt. One that commands the size of its force
(q2q_sim.experiments.validation.recorded.recorded_law) wants it along another tilt than that of the vehicle,
b. On the recorded flights this moves K_p by up to 2 % and K_d by 1 %, more than the ends of their intervals.

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

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from q2q_model.counted import counted
from q2q_model.identification.gains.altitude_record import AltitudeRecord, flight_numbers
from q2q_model.identification.gains.gain_equation import (
    FEED_FORWARD,
    FEWEST_ROWS,
    INTEGRAL,
    K_D,
    K_P,
    OFFSET,
    REF_ACC,
    REF_VEL,
    SHARES,
    GainEquation,
    design_of,
    gain_equation,
    predicting_flights,
    without_limited,
)
from q2q_model.identification.gains.huber_regression import (
    RESOLUTION,
    SIGNIFICANCE,
    huber_fit,
    robust_deviation,
    significance,
)
from q2q_model.identification.statistics.intervals import (
    EstimatingRows,
    Interval,
    Stretch,
    cluster_rows,
    intervals,
)
from q2q_model.signals.values import Array
from q2q_model.vehicle.altitude_loop import AltitudeLoop

BLOCK = 1.0
"""Minimum length of a cluster of residuals [s]."""
APART = 0.2
"""Difference of c from which two controllers compensate differently [-]; those of recorded flights of one
controller, each alone, differ by up to 0.08."""
TINY = float(np.finfo(float).tiny)
"""Square sum in place of 0 of a prediction without a row of full weight."""


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
    compensated: Mapping[str, float] = field(default_factory=dict)
    """c of each flight [-], by name; empty if not found from commands."""
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


def gains_from_commands(records: Sequence[AltitudeRecord]) -> GainFit:
    """Return the gains of the controller.

    Raises:
        ValueError: too few rows with commands.
    """
    whole = gain_equation(records)
    system = without_limited(whole)
    if system.target.size < FEWEST_ROWS:
        flights = len({record.name for record in records})  # a record may be a piece of one
        raise ValueError(
            f"{counted(system.target.size, 'row')} with thrust commands in "
            f"{counted(flights, 'flight')}, at references with rates; must be at least {FEWEST_ROWS}: "
            "record the topics command and reference, or fit the gains to trajectories"
        )
    terms = _needed_terms(system)
    design = design_of(system, terms)
    value, weight = huber_fit(design, system.target)
    residual = system.target - design @ value
    gains = [term for term in terms if term < SHARES]
    spread = intervals(value[: len(gains)], _rows(system, terms, residual, weight))
    found = dict(zip(gains, spread, strict=True))
    others = predicting_flights(system)[1:] if SHARES in terms else np.empty(0, np.intp)
    after = len(gains) + others.size
    added = dict(zip(others.tolist(), value[len(gains) : after].tolist(), strict=True))
    loop = AltitudeLoop(
        k_p=found[K_P].value,
        k_d=found[K_D].value,
        k_i=_value(found, INTEGRAL),
        offset=float(value[after:].mean()) if OFFSET in terms else 0.0,
    )
    return GainFit(
        loop=loop,
        k_p=found[K_P],
        k_d=found[K_D],
        needs_offset=OFFSET in terms,
        needs_integral=INTEGRAL in terms,
        rms=robust_deviation(residual),
        compensated=_shares(records, found, added),
        of_rates=(_value(found, REF_VEL), _value(found, REF_ACC)),
        limited=1.0 - system.target.size / whole.target.size,
    )


def _needed_terms(system: GainEquation) -> list[int]:
    """Return the terms without those whose coefficients are not significant."""
    terms = [K_P, K_D, INTEGRAL, FEED_FORWARD, REF_VEL, REF_ACC, SHARES, OFFSET]
    for term in (SHARES, REF_ACC, REF_VEL, FEED_FORWARD, INTEGRAL, OFFSET):
        if not _is_needed(system, terms, term):
            terms.remove(term)
    return terms


def _value(found: Mapping[int, Interval], term: int) -> float:
    """Return the coefficient of a term, 0 if it is not needed."""
    return found[term].value if term in found else 0.0


def _rows(system: GainEquation, terms: Sequence[int], residual: Array, weight: Array) -> EstimatingRows:
    """Return the estimating rows of the gains, with offsets and shares of other flights eliminated.

    Huber's psi is the weighted residual; its slope is 1 for rows of full weight, else 0.
    """
    columns = np.concatenate(
        (design_of(system, [term for term in terms if term < SHARES]), system.columns[:, [FEED_FORWARD]]),
        axis=1,
    )
    slope = (weight == 1.0).astype(np.float64)
    psi = weight * np.copysign(np.maximum(np.abs(residual), RESOLUTION), residual)
    stretches = []
    for group in np.unique(system.group):
        own = system.group == group
        if OFFSET in terms:
            columns[own] -= slope[own] @ columns[own] / max(slope[own].sum(), 1.0)
        stretches.append(Stretch(int(system.flight[own][0]), system.t[own], psi[own]))
    gains, expected = columns[:, :-1], columns[:, -1]
    for flight in predicting_flights(system)[1:] if SHARES in terms else ():
        own = system.flight == flight
        weighted = slope[own] * expected[own]
        gains[own] -= np.outer(expected[own], weighted @ gains[own] / max(weighted @ expected[own], TINY))
    return EstimatingRows(gains, psi, slope, cluster_rows(stretches, BLOCK))


def _shares(
    records: Sequence[AltitudeRecord], found: Mapping[int, Interval], added: Mapping[int, float]
) -> dict[str, float]:
    """Return c of each flight, by name, from that of the first and what others add to it, by number."""
    first = found[FEED_FORWARD].value if FEED_FORWARD in found else 0.0
    numbers = zip(records, flight_numbers(records), strict=True)
    return {record.name: first + added.get(number, 0.0) for record, number in numbers}


def _shares_are_apart(system: GainEquation, terms: Sequence[int]) -> bool:
    """Return whether c of any two flights, each with its own, differ by more than APART."""
    others = predicting_flights(system)[1:].size
    if not others:
        return False
    value, _ = huber_fit(design_of(system, terms), system.target)
    first = terms.index(OFFSET) - 1  # SHARES and OFFSET are the last terms
    return bool(np.ptp(np.append(value[first : first + others], 0.0)) > APART)


def _is_needed(system: GainEquation, terms: list[int], term: int) -> bool:
    """Return whether an F test finds `term` significant."""
    if term == SHARES and not _shares_are_apart(system, terms):
        return False
    if term < SHARES and np.ptp(system.columns[:, term]) == 0.0:
        return False
    whole, less = design_of(system, terms), design_of(system, [other for other in terms if other != term])
    return significance(whole, less, system.target) < SIGNIFICANCE
