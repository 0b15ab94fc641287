"""Check of the accelerometer against the commanded thrust in clear air.

There (R f_body)_z = s lagged(U1) b_z / m + o. The offset o at s = 1 shows a wrong mass, or an accelerometer
without gravity or with it twice; the slope s shows other units than m/s^2. With the correlation r of both
sides and their deviations, the two regression lines enclose s:

    r dev(f) / dev(U1 b_z / m) <= s <= dev(f) / dev(U1 b_z / m) / r

The first is too small in gusts, which commands answer, and the second too large with noise of the
accelerometer. r is replaced by its lower bound tanh(artanh r - 1.96 / N^1/2) for N independent rows: where
the thrust hardly varies, as in hover, that is 0, and the slope may be any.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from q2q_model.flights.flight import Flight
from q2q_model.identification.push.push_samples import FEWEST_FREE, scored_rows
from q2q_model.identification.push.recorded_push import push_of_sensors, recorded_acceleration
from q2q_model.identification.statistics.intervals import Z95
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import GRAVITY, VEHICLES, Vehicle

MOST_OFFSET = 0.1 * GRAVITY
"""Largest offset of a vehicle of the given mass [m/s^2]: at most 0.67 in recorded flights of 34 g."""
SLOPES = (0.7, 1.3)
"""Bounds of the slope [-]: the lines of recorded flights enclose some slope of 0.9 to 1.1."""
OFF_GRAVITY = 0.5 * GRAVITY
"""Difference of the accelerometer from g in clear air from which it is wrong, not the mass [m/s^2]: without
gravity, with it twice or in units of g it is off by 0.9 g or more."""
CORRELATED = 25
"""Rows that count as one: at 100 Hz a quarter of a second, over which gusts and their answers last."""


@dataclass(frozen=True, slots=True)
class _Agreement:
    """Accelerometer of one vehicle of one flight against its commands."""

    offset: float
    """[m/s^2]"""
    felt: float
    """Median of the accelerometer, upwards [m/s^2]."""
    slopes: tuple[float, float]
    """Slopes of both regression lines [-]."""


def sensor_notes(flights: Sequence[Flight], vehicle: Vehicle) -> list[str]:
    """Return notes on vehicles whose accelerometer contradicts the commands for `vehicle`."""
    found = [one for flight in flights for one in _agreements(flight, vehicle)]
    shifted = [one for one in found if abs(one.offset) > MOST_OFFSET]
    scaled = [one.slopes for one in found if one.slopes[1] < SLOPES[0] or one.slopes[0] > SLOPES[1]]
    return _shift_note(shifted, len(found), vehicle) or _scale_note(scaled, len(found))


def _shift_note(shifted: Sequence[_Agreement], count: int, vehicle: Vehicle) -> list[str]:
    if not shifted:
        return []
    offset, felt = np.median([(one.offset, one.felt) for one in shifted], axis=0).tolist()
    carried = vehicle.mass * (1.0 - offset / GRAVITY)
    cause = gravity_reason(felt) or (
        f"{vehicle.name} weighs {1e3 * vehicle.mass:.1f} g, and the thrust carries {1e3 * carried:.1f} g: "
        f"{mass_remedy(carried, vehicle)}"
    )
    return [
        (
            f"accelerometer less thrust / mass is {offset:.2f} m/s^2 in clear air for {len(shifted)} of "
            f"{count} vehicles of flights, expected at most {MOST_OFFSET:.2f}: {cause}"
        )
    ]


def gravity_reason(felt: float) -> str:
    """Return why an accelerometer is wrong that reads `felt` [m/s^2] in clear air; empty if that may be g."""
    if abs(felt - GRAVITY) < OFF_GRAVITY:
        return ""
    return (
        f"the accelerometer reads {felt:.2f} m/s^2 upwards: record the specific force, {GRAVITY:.2f} m/s^2 "
        "upwards at rest; az of a table is without gravity, 0 at rest"
    )


def mass_remedy(carried: float, vehicle: Vehicle) -> str:
    """Return what to do where the thrust carries another mass [kg] than that of `vehicle`."""
    fits = [
        one.name for one in VEHICLES.values() if abs(one.mass - carried) < MOST_OFFSET / GRAVITY * one.mass
    ]
    if fits:
        return f"give the vehicle that was flown (--vehicle, {' or '.join(fits)} by that mass)"
    return (
        f"no vehicle of --vehicle has that mass: in a table scale thrust by {vehicle.mass / carried:.3g} "
        "(bag_import --columns), or in Python give identification.identify a Vehicle of that mass"
    )


def _scale_note(scaled: Sequence[tuple[float, float]], count: int) -> list[str]:
    if not scaled:
        return []
    low, high = np.median(np.array(scaled), axis=0)
    return [
        (
            f"accelerometer over thrust / mass has a slope of {low:.2f} to {high:.2f} in clear air for "
            f"{len(scaled)} of {count} vehicles of flights, expected {SLOPES[0]:g} to {SLOPES[1]:g}: check "
            "that it is in m/s^2 and thrust in newtons"
        )
    ]


def _agreements(flight: Flight, vehicle: Vehicle) -> list[_Agreement]:
    """Return the agreement of every vehicle with enough rows in clear air."""
    found = recorded_acceleration(flight, vehicle)
    record = push_of_sensors(flight, vehicle, vehicle.thrust_lag)
    if found is None or record is None:
        return []
    free = [rows.free for rows in scored_rows(record)]
    felt = found.specific_force
    lift = felt - record.push
    return [
        _Agreement(
            float(np.median(record.push[rows, i])),
            float(np.median(felt[rows, i])),
            _slopes(lift[rows, i], felt[rows, i]),
        )
        for i, rows in enumerate(free)
        if rows.sum() >= FEWEST_FREE
    ]


def _slopes(lift: Array, felt: Array) -> tuple[float, float]:
    """Return the slopes of both regression lines; 0 and infinite if the two may not rise together."""
    lift, felt = lift - lift.mean(), felt - felt.mean()
    along = float(lift @ felt)
    if along <= 0.0:
        return 0.0, np.inf
    wide = float(np.sqrt((felt @ felt) / (lift @ lift)))
    r, doubt = along / float(lift @ lift) / wide, float(np.tanh(Z95 * np.sqrt(CORRELATED / lift.size)))
    rising = (r - doubt) / (1.0 - r * doubt)  # tanh(artanh r - artanh doubt)
    return (rising * wide, wide / rising) if rising > 0.0 else (0.0, np.inf)
