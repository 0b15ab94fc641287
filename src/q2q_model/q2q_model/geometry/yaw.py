"""Yaw of one quaternion, for compiled code; q2q_model.geometry.rotations loads without the compiler."""

import math

from q2q_model.compiled import compiled


@compiled
def yaw_of(x: float, y: float, z: float, w: float) -> float:
    """Return yaw psi [rad] of a quaternion, body to world (q2q_model.geometry.rotations)."""
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
