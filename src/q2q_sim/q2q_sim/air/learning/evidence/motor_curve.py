"""Thrust of the motors by duty and battery, of each vehicle and flight.

    T / m g = (d u / p)^k,   u = u_0 - rho t - s d        d: mean duty, u: battery voltage under load

d and u are taken after the thrust lag. Feedback makes the duty answer to gusts, which bends single flights'
k either way: their median is used.

| symbol | name | meaning [unit] |
|---|---|---|
| k | power | [-] |
| p | hover_volts | effective voltage d u at hover [V] |
| u_0 | start_volts | battery under the load of hover at the start [V] |
| rho | discharge | fall of the voltage [V/s] |
| s | sag | fall of the voltage by duty [V] |
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from q2q_model.identification.force.recorded_force import lagged
from q2q_model.signals.values import Array
from q2q_sim.air.learning.evidence.air_record import AirRecord, Motors

FEWEST = 500
"""Fewest rows of a vehicle in flight: 5 s at 100 Hz."""
FLYING = 0.7
"""Thrust over hover thrust above which a vehicle flies [-]."""
USUAL_POWER = 1.5
"""k without a motor log [-]: that of the recorded flights."""


@dataclass(frozen=True, slots=True)
class MotorCurve:
    """Motor curve of one vehicle of a flight."""

    power: float
    hover_volts: float
    start_volts: float
    discharge: float
    sag: float

    def headroom(self, volts: float, power: float) -> float:
        """Return the thrust at full duty over that of hover, for a voltage at hover [V]."""
        at_full = volts - self.sag * (1.0 - self.hover_volts / volts)
        return float((at_full / self.hover_volts) ** power)


def motor_curves(records: Sequence[AirRecord]) -> list[MotorCurve]:
    """Return the curve of every vehicle that flies long enough with a motor log."""
    found = []
    for record in records:
        if record.motors is not None:
            found += _curves(record, record.motors)
    return found


def usual_power(curves: Sequence[MotorCurve]) -> float:
    """Return the median k."""
    return float(np.median([one.power for one in curves])) if curves else USUAL_POWER


def _curves(record: AirRecord, motors: Motors) -> list[MotorCurve]:
    t = record.motion.t
    duty, volts = (lagged(values, t, record.lag) for values in (motors.duty.mean(axis=2), motors.volts))
    found = []
    for i in range(record.vehicles):
        rows = record.measured[:, i] & (record.strength[:, i] > FLYING) & (duty[:, i] * volts[:, i] > 0.0)
        if rows.sum() >= FEWEST:
            found.append(_curve(t[rows], duty[rows, i], volts[rows, i], record.strength[rows, i]))
    return found


def _curve(t: Array, duty: Array, volts: Array, strength: Array) -> MotorCurve:
    apart, load = np.log(duty * volts), np.log(strength)
    power, _ = np.polyfit(apart, load, 1)
    hover = float(np.exp(np.median(apart[np.abs(load) <= np.quantile(np.abs(load), 0.5)])))
    columns = np.stack([np.ones_like(t), t - t[0], duty - duty.mean()], axis=1)
    start, slope, by_duty = np.linalg.lstsq(columns, volts)[0]
    return MotorCurve(float(power), hover, float(start), -float(slope), -float(by_duty))
