"""Thrust of the motors by duty and battery, of each vehicle and flight.

    T / m g = mean over motors of (d_m u / p)^k,   u = u_0 - rho t - s d

taken after the thrust lag. k has the least squared error of all vehicles together: the thrust of one that
only hovers does not determine it. The motors are taken one by one: under the edge of a wake they differ by
most of their range, and as thrust is convex in duty, the mean duty falls there while the thrust does not.

| symbol | name | meaning [unit] |
|---|---|---|
| d_m, d | | duty of a motor, mean duty [-] |
| k | power | [-] |
| p | hover_volts | effective voltage d u at hover [V] |
| u_0 | start_volts | battery under the load of hover at the start [V] |
| rho | discharge | fall of the voltage [V/s] |
| s | sag | fall of the voltage by duty [V] |
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from q2q_model.flights.first_order_lag import first_order_lag
from q2q_model.identification.push.push_samples import FLOOR
from q2q_model.identification.push.recorded_push import FULL_DUTY
from q2q_model.signals.values import Array, Mask, Rows
from q2q_sim.air.learning.records.air_record import AirRecord, Motors

FEWEST_ROWS = 500
"""Fewest rows of a vehicle in flight: 5 s at 100 Hz."""
POWERS = np.linspace(1.0, 3.0, 21)
"""k to choose from: thrust in proportion to the speed of the rotors is 1, to its square 2."""
USUAL_POWER = 1.9
"""k without a motor log [-]: that of the recorded flights."""


@dataclass(frozen=True, slots=True)
class MotorCurve:
    """Motor curve of one vehicle of a flight."""

    squared_residuals: Array
    """Squared error of T / m g at each of POWERS, sum over rows."""
    hover_volts: float
    """At the vehicle's own best power."""
    start_volts: float
    discharge: float
    sag: float
    work: Array
    """(d_m u)^k of each motor over their mean in clear air [-], (4,)."""

    def headroom(self, volts: float, power: float) -> float:
        """Return the thrust at full duty over that of hover, for a voltage at hover [V]."""
        at_full = volts - self.sag * (FULL_DUTY - self.hover_volts / volts)
        return float((FULL_DUTY * at_full / self.hover_volts) ** power)


def motor_curves(records: Sequence[AirRecord]) -> list[MotorCurve]:
    """Return the curve of every vehicle that flies long enough with a motor log."""
    found = []
    for record in records:
        if record.motors is not None:
            found += _curves(record, record.motors)
    return found


def usual_power(curves: Sequence[MotorCurve]) -> float:
    """Return the k of all vehicles together."""
    if not curves:
        return USUAL_POWER
    return float(POWERS[np.argmin(np.sum([one.squared_residuals for one in curves], axis=0))])


def _curves(record: AirRecord, motors: Motors) -> list[MotorCurve]:
    """Return the curves of the vehicles that fly long enough."""
    found = []
    for i in range(record.vehicles):
        flying = record.flying[:, i] & (record.motion.pos[:, i, 2] > FLOOR)
        turning = (motors.duty[:, i] > 0.0).all(axis=1) & (motors.volts[:, i] > 0.0)
        rows = record.measured[:, i] & flying & turning
        if rows.sum() >= FEWEST_ROWS:
            found.append(_curve(record, motors, i, np.flatnonzero(rows)))
    return found


def _curve(record: AirRecord, motors: Motors, i: int, rows: Rows) -> MotorCurve:
    t, thrust_ratio = record.motion.t, record.thrust_ratio[rows, i]
    each = np.maximum(motors.duty[:, i] * motors.volts[:, i, None], 0.0)  # d_m u, (T, 4)
    powers = np.stack([(each**power).mean(axis=1) for power in POWERS], axis=1)
    felt = first_order_lag(powers, t, record.lag)[rows]  # (k, K)
    scale = (thrust_ratio @ felt) / (felt**2).sum(axis=0)
    squared_residuals = ((thrust_ratio[:, None] - scale * felt) ** 2).sum(axis=0)
    best = int(np.argmin(squared_residuals))
    mean = np.stack([motors.duty[:, i].mean(axis=1), motors.volts[:, i]], axis=1)
    duty, volts = first_order_lag(mean, t, record.lag)[rows].T
    columns = np.stack([np.ones(rows.size), t[rows] - t[rows[0]], duty - duty.mean()], axis=1)
    start, fall, by_duty = map(float, np.linalg.lstsq(columns, volts)[0])
    hover_volts = float(scale[best] ** (-1.0 / POWERS[best]))
    return MotorCurve(
        squared_residuals, hover_volts, start, -fall, -by_duty, _work(each, record.clear[:, i], rows)
    )


def _work(each: Array, clear: Mask, rows: Rows) -> Array:
    """Return the work of each motor over their mean, in clear air if there are enough rows of it."""
    free = rows[clear[rows]]
    done = each[free if free.size >= FEWEST_ROWS else rows] ** USUAL_POWER
    return np.asarray(np.median(done / done.mean(axis=1, keepdims=True), axis=0))
