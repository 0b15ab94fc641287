"""Refusal of tables whose velocities are not those of their positions, as of other units, signs or axes.

With d the change of position of an axis over a window, and e that by the velocity in its middle,

    d = x(t + WINDOW_S) - x(t)      e = v(t + WINDOW_S / 2) WINDOW_S

two regression lines enclose the ratio of velocities, as positions and velocities may be noisy:

    sum d e / sum d^2 <= ratio <= sum e^2 / sum d e

where the axis moves. Both are 0.99 to 1.15 in the 23 public flights that have velocities (estimates onboard).
"""

import numpy as np

from q2q_model.signals.values import Array, Names

WINDOW_S = 0.25
"""Over it, noise of 1 mm is 6 mm/s [s]."""
SLOWEST = 0.2
"""Least change of position over a window that counts as motion [m/s]."""
LEAST_S = 1.0
"""Least time of such motion to judge by [s]."""
WRONG = 10.0
"""Times the usual value from which a single one is wrong [-]."""
ALIKE = 0.5
"""Least magnitude of the correlation of d and e: beneath it, noise hides the ratio."""
RATIOS = (1.0 / 3.0, 3.0)
"""Bounds of the ratio: km/h give 3.6, feet 3.28."""


def check_velocities(t: Array, names: Names, pos: Array, vel: Array) -> None:
    """Raise ValueError if a velocity contradicts the positions of its axis.

    Args:
        t: times [s], rising, (T,).
        names: the n vehicles.
        pos: positions [m], (T, n, 3).
        vel: velocities [m/s], (T, n, 3).
    """
    for i, name in enumerate(names):
        for axis, letter in enumerate("xyz"):
            ratio = _ratio(t, pos[:, i, axis], vel[:, i, axis])
            if not RATIOS[0] <= ratio <= RATIOS[1]:
                raise ValueError(
                    f"v{letter} of {name} is {ratio:.3g} times the change of {letter} by time, expected "
                    f"{RATIOS[0]:.2g} to {RATIOS[1]:.2g}: it must be in m/s in the axes of x, y, z; a column "
                    "map scales it (bag_import --columns), or leave vx, vy, vz out"
                )


def _ratio(t: Array, pos: Array, vel: Array) -> float:
    """Return the ratio of an axis, (T,) each; 1 where it hardly moves, or noise hides the motion."""
    known = np.isfinite(pos) & np.isfinite(vel)
    t, pos, vel = t[known], pos[known], vel[known]
    end = np.searchsorted(t, t + WINDOW_S)
    start = np.flatnonzero(end < t.size)
    end = end[start]
    start, end = (rows[t[end] - t[start] < 2.0 * WINDOW_S] for rows in (start, end))  # no longer hole
    moved = pos[end] - pos[start]
    moves = np.abs(moved) > SLOWEST * (t[end] - t[start])
    if not moves.any() or moves.sum() * float(np.median(np.diff(t))) < LEAST_S:
        return 1.0
    start, end, moved = start[moves], end[moves], moved[moves]
    stated = np.interp(0.5 * (t[start] + t[end]), t, vel) * (t[end] - t[start])
    if not stated.any():
        return 0.0
    usual = (np.abs(moved) <= WRONG * np.median(np.abs(moved))) & (
        np.abs(stated) <= WRONG * np.quantile(np.abs(stated), 0.75)
    )
    stated, moved = stated[usual], moved[usual]
    squares, along = np.array([moved @ moved, stated @ stated]), float(stated @ moved)
    if along**2 < ALIKE**2 * squares.prod():
        return 1.0
    lines = sorted((along / squares[0], squares[1] / along))
    return float(np.clip(1.0, *lines))
