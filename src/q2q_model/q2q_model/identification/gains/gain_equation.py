"""Regression equation of the gains of the altitude loop: a row for each tick, a column for each term.

Symbols and terms are those of command_gains.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from q2q_model.identification.gains.altitude_record import AltitudeRecord, flight_numbers
from q2q_model.identification.gains.velocity_limit import at_velocity_limit
from q2q_model.signals.values import Array, Mask, Rows

FEWEST_ROWS = 200
"""Fewest rows: 2 s at 100 Hz."""
K_P, K_D, INTEGRAL, FEED_FORWARD, REF_VEL, REF_ACC, SHARES, OFFSET = range(8)
"""Terms of the equation. SHARES adds to c, one column for each other flight with a prediction than the first;
OFFSET is one column for each vehicle of each flight."""


@dataclass(frozen=True, slots=True)
class GainEquation:
    """Regression of all vehicles of all flights."""

    target: Array
    columns: Array
    """K_P to REF_ACC, (rows, 6); that of FEED_FORWARD is -eta_ff."""
    group: Array
    """Number of record and vehicle, (rows,)."""
    flight: Array
    """Number of the flight, (rows,)."""
    t: Array
    """[s], (rows,), ascending within a group."""
    limited: Mask
    """Whether z_ref'' is the difference of a velocity setpoint at its limit, (rows,)."""


def gain_equation(records: Sequence[AltitudeRecord]) -> GainEquation:
    """Return the equation of all vehicles of all records."""
    each = [
        (record, i, flight)
        for record, flight in zip(records, flight_numbers(records), strict=True)
        for i in range(len(record.names))
    ]
    parts = [_equation(record, i, group, flight) for group, (record, i, flight) in enumerate(each)]
    stacked = {
        one.name: np.concatenate([getattr(part, one.name) for part in parts]) for one in fields(GainEquation)
    }
    return GainEquation(**stacked)


def without_limited(system: GainEquation) -> GainEquation:
    """Return the rows whose velocity setpoint is not at its limit; all if those are few, as in a climb."""
    rows = ~system.limited
    if rows.sum() < FEWEST_ROWS:
        return system
    return GainEquation(**{one.name: getattr(system, one.name)[rows] for one in fields(system)})


def _equation(record: AltitudeRecord, i: int, group: int, flight: int) -> GainEquation:
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
    return GainEquation(target[known], columns[known], groups, flights, t, limited)


def design_of(system: GainEquation, terms: Sequence[int]) -> Array:
    """Return the columns of `terms` in order, (rows, p): gains, shares, offsets."""
    parts = [system.columns[:, [term for term in terms if term < SHARES]]]
    if SHARES in terms:
        own = system.flight[:, None] == predicting_flights(system)[1:]
        parts.append(system.columns[:, FEED_FORWARD, None] * own)
    if OFFSET in terms:
        own = system.group[:, None] == np.unique(system.group)
        parts.append(own.astype(np.float64))
    return np.concatenate(parts, axis=1)


def predicting_flights(system: GainEquation) -> Rows:
    """Return the numbers of the flights whose controllers had a prediction of the downwash."""
    return np.unique(system.flight[system.columns[:, FEED_FORWARD] != 0.0])
