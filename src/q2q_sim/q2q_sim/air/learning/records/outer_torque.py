"""Roll and pitch torque on a vehicle that its motors do not explain.

    tau = I w' - (tau_motors - trim),    f_m = T / 4 (1 + k (d_m - d) / d)

f_m: thrust of a motor, by its duty d_m after the thrust lag; d: mean duty, k: power of the motor curve; trim:
median of the motors' torque in clear air.
"""

import numpy as np

from q2q_control.attitude.allocation import rotor_frame, wrench_of
from q2q_model.flights.first_order_lag import first_order_lag
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import Vehicle
from q2q_sim.air.learning.records.air_record import AirRecord, Motors

FEWEST_CLEAR = 100
"""Fewest rows in clear air for the trim: 1 s at 100 Hz."""


def has_trim(record: AirRecord, i: int) -> bool:
    """Return whether a vehicle has a motor log, rates and enough rows in clear air."""
    known = record.motors is not None and np.isfinite(record.rate_body[:, i]).all()
    return bool(known and record.clear[:, i].sum() >= FEWEST_CLEAR)


def outer_torque(record: AirRecord, i: int, vehicle: Vehicle, power: float) -> Array:
    """Return tau [N m], body x and y, (T, 2), of a vehicle with a trim, for a power of the motor curve."""
    if record.motors is None:
        raise ValueError(f"flight {record.name} has no motor log: record pwm1 to pwm4")
    turning = np.gradient(record.rate_body[:, i, :2], record.motion.t, axis=0)
    motors = _motor_torque(record, record.motors, i, vehicle, power)
    trim = np.median(motors[record.clear[:, i]], axis=0)
    return np.asarray(np.array(vehicle.inertia)[:2] * turning - motors + trim)


def _motor_torque(record: AirRecord, motors: Motors, i: int, vehicle: Vehicle, power: float) -> Array:
    duty = first_order_lag(motors.duty[:, i], record.motion.t, record.lag)  # (T, 4)
    mean = np.maximum(duty.mean(axis=1, keepdims=True), 1e-3)
    quarter = 0.25 * vehicle.hover_thrust * record.thrust_ratio[:, i, None]
    thrust = quarter * (1.0 + power * (duty - mean) / mean)
    return wrench_of(thrust, rotor_frame(vehicle))[:, 1:3]
