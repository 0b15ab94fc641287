"""Drag of the rotors of a recorded flight's vehicles, read from their accelerometers.

    a = -k (v - (v . b) b)        b: body z, v: velocity [m/s], k: drag [1/s]

A rotor in translation is pushed back in its own plane, in proportion to the speed (Faessler, Franchi and
Scaramuzza, RA-L 2018). Thrust has no part in the plane, so an accelerometer shows nothing else there but its
bias: k is the slope of its x and y over the velocity in body axes, in clear air. The flights of June 2020 and
of 2019 show 0.36 to 0.48.
"""

import numpy as np

from q2q_model.geometry.rotations import UP, rotate, rotate_inverse
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import GRAVITY
from q2q_sim.experiments.validation.recorded.tracked_flight import TrackedFlight

FEWEST_ROWS = 200
"""Fewest rows of a vehicle: 2 s at 100 Hz."""


def drag_acceleration(drag: float, vel: Array, quat: Array) -> Array:
    """Return the acceleration by a drag [1/s] on velocities (..., 3) at attitudes (..., 4), world."""
    axis = rotate(quat, UP)
    return np.asarray(-drag * (vel - (vel * axis).sum(axis=-1, keepdims=True) * axis))


def read_drag(flight: TrackedFlight) -> float:
    """Return the drag of a flight's vehicles [1/s]; 0 without accelerometers or rows in clear air."""
    force = rotate_inverse(flight.quat, flight.acc + GRAVITY * UP)[..., :2]
    speed = rotate_inverse(flight.quat, flight.vel)[..., :2]
    product = square = 0.0
    for i in range(len(flight.names)):
        rows = flight.free[:, i] & flight.usable[:, i] & np.isfinite(force[:, i]).all(axis=1)
        if rows.sum() >= FEWEST_ROWS:
            felt, moved = (part[rows, i] - part[rows, i].mean(axis=0) for part in (force, speed))
            product += float((felt * moved).sum())
            square += float((moved**2).sum())
    return max(-product / square, 0.0) if square > 0.0 else 0.0
