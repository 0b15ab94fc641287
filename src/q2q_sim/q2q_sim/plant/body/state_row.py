"""Row of numbers that the compiled loops hold of one vehicle: its columns, and the row at rest."""

import numpy as np

from q2q_model.geometry.rotations import quat_from_euler
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import GRAVITY

X, Y, Z = 0, 1, 2
"""Columns of a state row: position [m], world."""
VX, VY, VZ = 3, 4, 5
"""Velocity [m/s], world."""
QX, QY, QZ, QW = 6, 7, 8, 9
"""Attitude, body to world."""
P, Q, R = 10, 11, 12
"""Body rates [rad/s]."""
F1, F2, F3, F4 = 13, 14, 15, 16
"""Rotor thrusts [N]."""
AX, AY, AZ = 17, 18, 19
"""Acceleration during the last step [m/s^2], world."""
ETA_Z, ETA_X, ETA_Y = 20, 21, 22
"""Push of the air [m/s^2], world."""
TX, TY, TZ = 23, 24, 25
"""Its torque [N m], body."""
ROTOR_MAX1, ROTOR_MAX2, ROTOR_MAX3, ROTOR_MAX4 = 26, 27, 28, 29
"""Largest thrust of each rotor [N], less its load (room_air.RateLoadTerm)."""
STATE_WIDTH = 30
POS, VEL, QUAT = slice(X, VX), slice(VX, QX), slice(QX, P)
RATE, ROTORS, ACC = slice(P, F1), slice(F1, AX), slice(AX, ETA_Z)
TORQUE = slice(TX, ROTOR_MAX1)

Two = tuple[float, float]


def state_at_rest(start: Array, mass: float) -> Array:
    """Return states (n, STATE_WIDTH) at rest at `start` (n, 4): x, y, z [m], yaw [rad].

    Above the ground the vehicles hover, on it their motors are off.
    """
    level = np.zeros(len(start))
    state = np.zeros((len(start), STATE_WIDTH))
    state[:, POS] = start[:, :3]
    state[:, QUAT] = quat_from_euler(level, level, start[:, 3])
    state[start[:, 2] > 0.0, ROTORS] = 0.25 * mass * GRAVITY
    state[:, ROTOR_MAX1:] = np.inf
    return state
