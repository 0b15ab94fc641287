"""Differences between vehicles and flights: vertical offset, thrust lag, headroom by battery.

    a_0 = median over clear air of (R f)_z - T_c b_z / m      T_c: commanded thrust after the thrust lag

for each vehicle of each flight, with the vehicle's nominal mass m. A mean offset beyond HEAVIEST is that of
another vehicle: its term is not learned. The motor curve is a median over flights; headroom is the median of
the flights', each at the voltage of its start, and its loss by volt the slope of the median curve between the
highest and the lowest of these voltages. The thrust lag is the vehicle's, the attitude loop LOOP.
"""

from collections.abc import Sequence

import numpy as np

from q2q_control.attitude.attitude_law import AttitudeParams
from q2q_model.identification.push.sensor_check import gravity_reason
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import GRAVITY, Vehicle
from q2q_sim.air.air_terms import VehicleTerm
from q2q_sim.air.learning.records.air_record import AirRecord
from q2q_sim.air.learning.records.motor_curve import MotorCurve, motor_curves, usual_power
from q2q_sim.air.learning.statistics.fitted import Fitted, LearnedTerm, fitted_value
from q2q_sim.air.learning.statistics.vehicle_spread import (
    deviation_of_draws,
    deviation_spread,
    mean_spread,
    spread_of_vehicles,
)

FEWEST_CLEAR = 200
"""Fewest rows of a vehicle in clear air: 2 s at 100 Hz."""
FEWEST_FLIGHTS = 2
"""Fewest flights of vehicles for a deviation."""
HEAVIEST = 0.1 * GRAVITY
"""Largest mean offset of a vehicle of the given mass [m/s^2]: thrust maps are off by a few per cent."""
OFFSETS = ("vehicle.offset_mean_mps2", "vehicle.offset_std_mps2")
HEADROOM = ("vehicle.headroom", "vehicle.headroom_per_volt", "vehicle.discharge_v_per_s")
BETWEEN = "vehicle.headroom_std"
MOTORS = "vehicle.motor_std"
LAG = "vehicle.thrust_lag_s"
LOOP = AttitudeParams(frequency=60.0, damping=3.0, lead_ratio=0.15)
"""Attitude loop of the recorded vehicles: a fast loop of the rate under one of the angle, of a gain of w / 6.

Damping and lead are those of least squares on the tilt of dc19_randomwalk_ss_04 (3.0, 0.14) and
dc21_randomwalk_ss_00 (3.0, 0.14), 3.0 being the largest allowed; the frequency is the median of 16 flights
(q2q_sim.experiments.validation.recorded.recorded_law reads that of one).
"""


def vehicle_term(records: Sequence[AirRecord], vehicle: Vehicle) -> LearnedTerm[VehicleTerm] | None:
    """Return the differences; None with fewer than FEWEST_FLIGHTS of vehicles in clear air, or of others."""
    offsets = _offsets(records, vehicle)
    if offsets.size < FEWEST_FLIGHTS or abs(offsets.mean()) > HEAVIEST:
        return None
    values = [
        *_spread_of_offsets(offsets, vehicle.mass),
        Fitted(LAG, vehicle.thrust_lag, None, None, 0, f"not learned: that of {vehicle.name}"),
        *_headroom(motor_curves(records), vehicle),
    ]
    found = {one.path.removeprefix("vehicle."): one.value for one in values}
    term = VehicleTerm(
        **found,
        attitude_frequency=LOOP.frequency,
        attitude_damping=LOOP.damping,
        attitude_lead_ratio=LOOP.lead_ratio,
    )
    return LearnedTerm(term, tuple(values))


def hovering_mass(records: Sequence[AirRecord], vehicle: Vehicle) -> float | None:
    """Return the mass that the thrust commands carry in clear air [kg], None if unknown."""
    offsets = _offsets(records, vehicle)
    return float(vehicle.mass * (1.0 - offsets.mean() / GRAVITY)) if offsets.size >= FEWEST_FLIGHTS else None


def accelerometer_reason(records: Sequence[AirRecord]) -> str:
    """Return why the accelerometer is wrong, by its median in clear air; empty if it may be right."""
    found = [
        float(np.median(record.specific_force[rows, i, 2]))
        for record in records
        for i, rows in enumerate(record.felt.T)
        if rows.sum() >= FEWEST_CLEAR
    ]
    return gravity_reason(float(np.median(found))) if found else ""


def _offsets(records: Sequence[AirRecord], vehicle: Vehicle) -> Array:
    found = []
    for record in records:
        for i in range(record.vehicles):
            rows = record.felt[:, i] & np.isfinite(record.command[:, i])
            if rows.sum() >= FEWEST_CLEAR:
                lift = record.command[rows, i] * record.motion.axis[rows, i, 2] / vehicle.mass
                found.append(float(np.median(record.specific_force[rows, i, 2] - lift)))
    return np.array(found)


def _spread_of_offsets(offsets: Array, mass: float) -> list[Fitted]:
    spreads = (mean_spread(offsets), deviation_of_draws(offsets))
    source = f"flights of vehicles, for a mass of {mass * 1e3:.1f} g"
    return [
        fitted_value(spread, 0, path, offsets.size, source)
        for spread, path in zip(spreads, OFFSETS, strict=True)
    ]


def _headroom(curves: Sequence[MotorCurve], vehicle: Vehicle) -> list[Fitted]:
    if not curves:
        ratio = vehicle.thrust_max / vehicle.hover_thrust
        source = f"not learned: that of {vehicle.name}"
        return [
            Fitted(path, value, None, None, 0, source)
            for path, value in zip((*HEADROOM, BETWEEN, MOTORS), (ratio, 0.0, 0.0, 0.0, 0.0), strict=True)
        ]
    start = [one.start_volts for one in curves]
    full, empty = max(start), min(start)
    source = f"flights of vehicles with a motor log, {empty:.2f} to {full:.2f} V at hover"
    found = spread_of_vehicles(
        lambda weight: _usual_headroom(_drawn(curves, weight), full, empty), len(curves)
    )
    power = usual_power(curves)
    between = deviation_of_draws(np.array([one.headroom(one.start_volts, power) for one in curves]))
    work = np.array([one.work for one in curves])
    apart = deviation_spread(float(((work - 1.0) ** 2).sum()), 3 * len(curves))  # of four with a known mean
    return [
        *(fitted_value(found, k, path, len(curves), source) for k, path in enumerate(HEADROOM)),
        fitted_value(between, 0, BETWEEN, len(curves), source),
        fitted_value(apart, 0, MOTORS, len(curves), source),
    ]


def _usual_headroom(curves: Sequence[MotorCurve], full: float, empty: float) -> Array:
    """Return headroom at the start, its loss by volt between two voltages, and discharge: medians, (3,)."""
    power = usual_power(curves)
    at_full, at_empty = (np.median([one.headroom(volts, power) for one in curves]) for volts in (full, empty))
    per_volt = (at_full - at_empty) / (full - empty) if full > empty else 0.0
    started = np.median([one.headroom(one.start_volts, power) for one in curves])
    return np.array([started, per_volt, np.median([one.discharge for one in curves])])


def _drawn(curves: Sequence[MotorCurve], weight: Array) -> list[MotorCurve]:
    return [one for one, times in zip(curves, weight, strict=True) for _ in range(int(times))]
