"""Load of the rotors by roll and pitch rate, from what the motors do in clear air.

    tau = - c (p, q) - d (p', q')       tau: torque that the motors do not explain (outer_torque)

for each vehicle of each flight; the median of c counts. d takes up what the lag of the thrust is wrong by.

The motors of the recorded Crazyflies work 2 to 4 mN m for each rad/s wherever the vehicles turn: forty times
what momentum theory gives for rotors that move along their axes (0.08). Its cause is not known. Flown as a
torque, it slows the tilt to a spectrum that no recorded vehicle has; its mark on the recorded vehicles is
that their rotors reach their limit.
"""

from collections.abc import Sequence

import numpy as np

from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import Vehicle
from q2q_sim.air.air_terms import RateLoadTerm
from q2q_sim.air.learning.records.air_record import AirRecord
from q2q_sim.air.learning.records.motor_curve import motor_curves, usual_power
from q2q_sim.air.learning.records.outer_torque import has_trim, outer_torque
from q2q_sim.air.learning.statistics.fitted import LearnedTerm, fitted_value, not_negative
from q2q_sim.air.learning.statistics.vehicle_spread import median_spread

FEWEST_ROWS = 200
"""Fewest rows of a vehicle in clear air: 2 s at 100 Hz."""
LEAST_RATE = 0.05
"""Minimum rms rate of a vehicle [rad/s]: a hovering one does not show the load."""


def rate_load_term(records: Sequence[AirRecord], vehicle: Vehicle) -> LearnedTerm[RateLoadTerm] | None:
    """Return the load; None without a vehicle that turns for FEWEST_ROWS in clear air with a motor log."""
    power = usual_power(motor_curves(records))
    each = [
        _load(record, i, vehicle, power)
        for record in records
        for i in range(record.vehicles)
        if _turns(record, i)
    ]
    if not each:
        return None
    found = median_spread(np.array(each)[:, None], 0.0)
    source = "flights of vehicles that turn in clear air"
    value = not_negative(fitted_value(found, 0, "rate_load.nms", len(each), source))
    return LearnedTerm(RateLoadTerm(value.value), (value,))


def _turns(record: AirRecord, i: int) -> bool:
    rate: Array = record.rate_body[record.clear[:, i], i, :2]
    return len(rate) >= FEWEST_ROWS and has_trim(record, i) and bool(np.sqrt((rate**2).mean()) > LEAST_RATE)


def _load(record: AirRecord, i: int, vehicle: Vehicle, power: float) -> float:
    """Return c of one vehicle [N m s]."""
    rows, rate = record.clear[:, i], record.rate_body[:, i, :2]
    turning = np.gradient(rate, record.motion.t, axis=0)
    known = np.stack([rate[rows].ravel(), turning[rows].ravel()], axis=1)
    torque = outer_torque(record, i, vehicle, power)[rows].ravel()
    return -float(np.linalg.lstsq(known, torque)[0][0])
