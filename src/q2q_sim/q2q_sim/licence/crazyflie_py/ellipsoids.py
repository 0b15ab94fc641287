"""Module `util` of crazyflie_py: collisions of ellipsoids, and positions at random."""

import numpy as np
from scipy.spatial.distance import cdist

from q2q_model.signals.values import Array

TOUCH = 1.97
"""Distance in radii at which two ellipsoids count as touching: crazyflie_py."""
ROOM = 1.25
"""Volume of the cube over that of the cells of all points."""


def check_ellipsoid_collisions(positions: Array, radii: Array) -> Array:
    """Return which ellipsoids at positions (n, 3) with radii (3,) meet another one, (n,)."""
    apart = cdist(positions / radii, positions / radii)
    np.fill_diagonal(apart, np.inf)
    return np.asarray((apart < TOUCH).any(axis=1))


def poisson_disk_sample(n: int, dim: int, mindist: float) -> Array:
    """Return n points (n, dim) at random that are at least a distance apart."""
    size = (ROOM * n) ** (1.0 / dim) * mindist
    points: list[Array] = []
    while len(points) < n:
        point = size * np.random.uniform(-0.5, 0.5, dim)  # noqa: NPY002  programs seed numpy's generator
        if all(np.linalg.norm(point - other) >= mindist for other in points):
            points.append(point)
    return np.array(points)
