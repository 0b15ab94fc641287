"""Control allocation of an X quadcopter: collective thrust and torques to four limited rotors.

Body x forward, y left, z up; rotors counted as on the Crazyflie, seen from above:

    4 (turns right)   1 (turns left)        f1 front right, f2 rear right,
             x ^                            f3 rear left,   f4 front left
          y <--+
    3 (turns left)    2 (turns right)

    U1    = f1 + f2 + f3 + f4
    tau_x = h (-f1 - f2 + f3 + f4)          h = l / sqrt 2, positive roll lowers the right side
    tau_y = h (-f1 + f2 + f3 - f4)          positive pitch lowers the nose
    tau_z = c (-f1 + f2 - f3 + f4)          the drag of a left-turning rotor turns the body right

Limits 0 <= f <= f_max. The attitude comes first, since a vehicle that loses its tilt loses its position:
roll and pitch are kept (scaled together only if they need more than f_max between rotors), then yaw gets the
remaining range (position control needs tilt, not yaw), then the collective is shifted until all rotors fit.

| symbol | name | meaning [unit] |
|---|---|---|
| U1 tau | wrench | collective thrust [N], body torques [N m], (..., 4) |
| f | rotors | thrust of each rotor [N], (..., 4) |
| l | arm | centre to motor [m] |
| c | drag_to_thrust | rotor drag torque over thrust [m] |
| f_max | rotor_max | largest thrust of one rotor, a quarter of thrust_max [N] |
"""

import math
from dataclasses import dataclass

import numpy as np

from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import Vehicle

_ROLL = np.array([-1.0, -1.0, 1.0, 1.0])
_PITCH = np.array([-1.0, 1.0, 1.0, -1.0])
_YAW = np.array([-1.0, 1.0, -1.0, 1.0])


@dataclass(frozen=True, slots=True)
class RotorFrame:
    """Rotor positions and largest thrust of each rotor."""

    lever: float
    """h [m]."""
    drag: float
    """c [m]."""
    rotor_max: float
    """f_max [N]."""


def rotor_frame(vehicle: Vehicle) -> RotorFrame:
    """Return the rotor frame of a vehicle."""
    return RotorFrame(vehicle.arm / math.sqrt(2.0), vehicle.drag_to_thrust, vehicle.thrust_max / 4.0)


def wrench_of(rotors: Array, frame: RotorFrame) -> Array:
    """Return U1, tau_x, tau_y, tau_z of rotor thrusts, (..., 4)."""
    rows = np.stack([np.ones(4), frame.lever * _ROLL, frame.lever * _PITCH, frame.drag * _YAW])
    return np.asarray(rotors @ rows.T)


def rotors_of(wrench: Array, frame: RotorFrame) -> Array:
    """Return the rotor thrusts [N], (..., 4), that give `wrench` (..., 4) as nearly as the limits allow."""
    collective, tilt, yaw = _quarters(wrench, frame)
    top = frame.rotor_max
    spread = np.max(tilt, axis=-1, keepdims=True) - np.min(tilt, axis=-1, keepdims=True)
    tilt = tilt * np.minimum(1.0, top / np.maximum(spread, top))
    both = tilt + yaw * _largest_share(tilt, yaw, top)
    low, high = -np.min(both, axis=-1, keepdims=True), top - np.max(both, axis=-1, keepdims=True)
    return np.asarray(both + np.clip(collective, low, np.maximum(low, high)))


def _quarters(wrench: Array, frame: RotorFrame) -> tuple[Array, Array, Array]:
    collective = 0.25 * wrench[..., :1]
    tilt = (wrench[..., 1:2] * _ROLL + wrench[..., 2:3] * _PITCH) * (0.25 / frame.lever)
    yaw = wrench[..., 3:] * _YAW * (0.25 / frame.drag)
    return collective, tilt, yaw


def _largest_share(tilt: Array, yaw: Array, top: float) -> Array:
    """Return the largest k in 0..1 for which the spread of tilt + k yaw is at most top, (..., 1)."""
    # every ordered pair of rotors i, j: (t_i - t_j) + k (y_i - y_j) <= top
    gap = tilt[..., :, None] - tilt[..., None, :]
    slope = yaw[..., :, None] - yaw[..., None, :]
    demand = np.maximum(slope, 0.0)
    margin = np.maximum(top - gap, 0.0)  # rounding may leave it slightly below 0
    tight = demand > margin
    share = np.where(tight, margin / np.where(tight, demand, 1.0), 1.0)
    return np.asarray(np.min(share, axis=(-2, -1))[..., None])
