"""Doubt whether attitudes lean the way that vehicles accelerate, as conjugated ones do not.

Thrust along body z, the only large force beside weight, accelerates a vehicle horizontally by g b_xy / b_z.
With W = WINDOW_S and weights w that fall from the middle of a window of 2 W to its ends, positions show

    a = (x(t + W) - 2 x(t) + x(t - W)) / W^2 = int w (g b_xy / b_z) dt = l

Both are taken from their medians, as an attitude may be askew. The cosine between them,

    r = sum (a . l) / sqrt(sum a^2 sum l^2)

is 0.89 to 0.99 for 57 vehicles of the public flights and 0.36 for one that hardly moves sideways. For
conjugated attitudes (world to body) it is -cos(yaw) times that: beyond a yaw of 70 degrees it shows nothing.
"""

import numpy as np

from q2q_model.geometry.rotations import UP, rotate
from q2q_model.signals.values import Array, Names
from q2q_model.vehicle.constants import GRAVITY

WINDOW_S = 0.24
"""Over it, noise of 1 mm is 0.04 m/s^2 [s]."""
STEP_S = 0.02
"""Of the samples taken [s]."""
HOLE_S = 0.1
"""Longest time between known samples that is interpolated [s]."""
LEAST_ACC = 0.1
"""Least root mean square of the acceleration to judge by [m/s^2]."""
MOST_CONJUGATED = -0.3
"""Largest cosine of an attitude in doubt [-]: conjugated ones of public flights have -0.36 to -0.99."""
LEAST_S = 5.0
"""Least time to judge by [s]."""


def tilt_direction_reason(t: Array, names: Names, pos: Array, quat: Array) -> str:
    """Return whose attitude seems to lean in another direction than it accelerates; empty for none.

    Args:
        t: times [s], rising, (T,).
        names: the n vehicles.
        pos: positions [m], (T, n, 3).
        quat: attitudes, (T, n, 4).
    """
    for i, name in enumerate(names):
        cosine = _cosine(t, pos[:, i], quat[:, i])
        if cosine < MOST_CONJUGATED:
            return (
                f"{name} accelerates to the side that its attitude leans away from (correlation "
                f"{cosine:.2f}, expected about 1): check that its quaternions turn body to world, or its "
                "angles have the signs of docs/bags.md, in the axes of the positions"
            )
    return ""


def _cosine(t: Array, pos: Array, quat: Array) -> float:
    """Return r of one vehicle; 1 where it cannot be judged."""
    known = np.isfinite(pos).all(axis=1) & np.isfinite(quat).all(axis=1)
    t, pos, up = t[known], pos[known], rotate(quat[known], UP)
    at = np.arange(t[0], t[-1], STEP_S) if t.size else np.empty(0)
    half = round(WINDOW_S / STEP_S)
    if at.size * STEP_S < LEAST_S:
        return 1.0
    weights = np.concatenate([np.arange(1, half), np.arange(half, 0, -1)]) / half**2
    lean = GRAVITY * up[:, :2] / np.maximum(up[:, 2:], 0.5)
    leant = np.stack([np.convolve(np.interp(at, t, one), weights, "valid") for one in lean.T], axis=1)
    path = np.stack([np.interp(at, t, one) for one in pos[:, :2].T], axis=1)
    felt = (path[2 * half :] - 2.0 * path[half:-half] + path[: -2 * half]) / WINDOW_S**2
    later = np.minimum(np.searchsorted(t, at, side="right"), t.size - 1)
    hole = np.concatenate([[0], np.cumsum(t[later] - t[later - 1] > HOLE_S)])
    rows = hole[2 * half + 1 :] == hole[: -2 * half - 1]
    if rows.sum() * STEP_S < LEAST_S:
        return 1.0
    felt, leant = (one[rows] - np.median(one[rows], axis=0) for one in (felt, leant[1:-1]))
    if np.sqrt((felt**2).sum(axis=1).mean()) < LEAST_ACC or not leant.any():
        return 1.0
    return float((felt * leant).sum() / np.sqrt((felt**2).sum() * (leant**2).sum()))
