"""Doubt whether vehicles are upright, as with quaternions in another order or a frame whose z is not up."""

import numpy as np

from q2q_model.flights.flight import Flight
from q2q_model.geometry.rotations import UP, level_where_unknown, rotate
from q2q_model.signals.values import Array

LEAST_UP = 0.5
"""Minimum median of the vertical component of body z [-]: a tilt of 60 degrees."""


def check_upright(flight: Flight) -> None:
    """Raise ValueError if body z of a vehicle does not point up in the median of its flight."""
    if reason := tilt_reason(flight):
        raise ValueError(f"flight {flight.name}: {reason}")


def tilt_reason(flight: Flight) -> str:
    """Return why the attitude of a vehicle seems to be wrong; empty if all are upright in the median."""
    up = body_z(flight)[..., 2]
    for i, name in enumerate(flight.names):
        flies = flight.thrust[:, i] > 0.0
        median = float(np.median(up[flies, i] if flies.any() else up[:, i]))
        if median < LEAST_UP:
            return (
                f"body z of {name} points {median:.2f} upwards in the median (minimum {LEAST_UP:g}): check "
                "that quaternions are in the order x y z w and that z is up"
            )
    return ""


def body_z(flight: Flight) -> Array:
    """Return body z, filtered, else that of motion capture, else upwards, world, (T, n, 3)."""
    quat = np.where(np.isfinite(flight.quat), flight.quat, flight.mocap_quat)
    return rotate(level_where_unknown(quat), UP)
