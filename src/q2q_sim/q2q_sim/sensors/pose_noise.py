"""Noise on the poses of motion capture, compiled."""

import math

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array

_SMALL_ANGLE = 1e-8
"""Below this sin(x)/x is 1 to the last digit [rad]."""


@compiled
def add_noise(
    truth: tuple[Array, Array], noise: Array, sizes: tuple[float, float], pos: Array, quat: Array
) -> None:
    """Write noisy poses; the attitude is turned by exp of a rotation vector (q2q_model.geometry.rotations).

    Args:
        truth: pos, quat.
        noise: standard normal deviates, (2, n, 3).
        sizes: standard deviations [m], [rad].
        pos: written, (n, 3).
        quat: written, (n, 4).
    """
    true_pos, true_quat = truth
    for i in range(true_pos.shape[0]):
        squared = 0.0
        for k in range(3):
            pos[i, k] = true_pos[i, k] + sizes[0] * noise[0, i, k]
            squared += (sizes[1] * noise[1, i, k]) ** 2
        angle = math.sqrt(squared)
        scale = sizes[1] * (0.5 if angle < _SMALL_ANGLE else math.sin(0.5 * angle) / angle)
        a, b, c, d = (
            scale * noise[1, i, 0],
            scale * noise[1, i, 1],
            scale * noise[1, i, 2],
            math.cos(0.5 * angle),
        )
        x, y, z, w = true_quat[i, 0], true_quat[i, 1], true_quat[i, 2], true_quat[i, 3]
        quat[i, 0] = w * a + x * d + y * c - z * b
        quat[i, 1] = w * b + y * d + z * a - x * c
        quat[i, 2] = w * c + z * d + x * b - y * a
        quat[i, 3] = w * d - x * a - y * b - z * c
