"""Thrust and attitude of a trajectory: a quadcopter is differentially flat in x, y, z and yaw.

With (4)-(6) the thrust carries f = r'' + g e_z: U1 = m |f|, and its direction b = f / |f| is the body's z,

    b = (cos phi sin theta cos psi + sin phi sin psi,
         cos phi sin theta sin psi - sin phi cos psi,
         cos phi cos theta)

    sin phi = b_x sin psi - b_y cos psi,    tan theta = (b_x cos psi + b_y sin psi) / b_z

(Mellinger and Kumar, 2011). A vehicle in free fall, f = 0, has no attitude: NaN.
"""

from dataclasses import dataclass

import numpy as np

from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import GRAVITY


@dataclass(frozen=True, slots=True)
class FlatState:
    """State and inputs by differential flatness."""

    thrust: Array
    """Collective, over mass [m/s^2], (...,)."""
    roll: Array
    """phi [rad], (...,)."""
    pitch: Array
    """theta [rad], (...,)."""


def flat_state(acc: Array, yaw: Array) -> FlatState:
    """Return thrust and attitude for accelerations [m/s^2] (..., 3) and yaw psi [rad] (...,)."""
    force = acc + np.array([0.0, 0.0, GRAVITY])
    thrust = np.sqrt((force**2).sum(-1))
    some = np.where(thrust > 0.0, thrust, np.nan)
    bx, by, bz = (force[..., axis] / some for axis in range(3))
    sine, cosine = np.sin(yaw), np.cos(yaw)
    roll = np.arcsin(np.clip(bx * sine - by * cosine, -1.0, 1.0))
    return FlatState(thrust, roll, np.arctan2(bx * cosine + by * sine, bz))
