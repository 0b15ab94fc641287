"""Acceleration by thrust: f / m R e_z - g e_z, of a measured attitude or a commanded one.

Compiled, because for a few vehicles numpy's calls cost ten times the arithmetic.
"""

import math

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.geometry.yaw import yaw_of
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import GRAVITY


@compiled
def thrust_acc_of_quat(quat: Array, thrust: Array, mass: float) -> Array:
    """Return the acceleration by thrust (n,) [N] of attitudes `quat` (n, 4) [m/s^2], world, (n, 3).

    `mass` is that of a vehicle [kg].
    """
    acc = np.empty((thrust.size, 3))
    for i in range(thrust.size):
        x, y, z, w = quat[i, 0], quat[i, 1], quat[i, 2], quat[i, 3]
        specific = thrust[i] / mass
        acc[i, 0] = 2.0 * (x * z + w * y) * specific
        acc[i, 1] = 2.0 * (y * z - w * x) * specific
        acc[i, 2] = (1.0 - 2.0 * (x * x + y * y)) * specific - GRAVITY
    return acc


@compiled
def thrust_acc_of_command(command: tuple[Array, Array, Array], quat: Array, mass: float) -> Array:
    """Return the acceleration by thrust of commands at the yaw of `quat` (n, 4) [m/s^2], world, (n, 3).

    A command is thrust [N], roll and pitch [rad], (n,) each; `mass` is that of a vehicle [kg].
    """
    thrust, roll, pitch = command
    acc = np.empty((thrust.size, 3))
    for i in range(thrust.size):
        yaw = yaw_of(quat[i, 0], quat[i, 1], quat[i, 2], quat[i, 3])
        forward, left = math.cos(roll[i]) * math.sin(pitch[i]), -math.sin(roll[i])
        specific = thrust[i] / mass
        acc[i, 0] = (forward * math.cos(yaw) - left * math.sin(yaw)) * specific
        acc[i, 1] = (forward * math.sin(yaw) + left * math.cos(yaw)) * specific
        acc[i, 2] = math.cos(roll[i]) * math.cos(pitch[i]) * specific - GRAVITY
    return acc
