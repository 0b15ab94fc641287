"""Arrays that a Riccati recursion works in."""

from typing import NamedTuple

import numpy as np

from q2q_model.compiled import FAST, compiled
from q2q_model.signals.values import Array


class Workspace(NamedTuple):
    """Policy, quadratic forms, cost-to-go and path of a problem with N stages and n inputs."""

    policy: Array
    """K and k of u = K x + k, side by side, (N, n, 3n + 1)."""
    quu: Array
    """(N, n, n)"""
    qux: Array
    """(N, n, 3n)"""
    qu: Array
    """(N, n)"""
    cost_matrix: Array
    """P of the stage ahead, (3n, 3n)."""
    cost_vector: Array
    """p of the stage ahead, (3n,)."""
    product: Array
    """Transpose of P A, (3n, 3n)."""
    ahead: Array
    """P c + p, (3n,)."""
    states: Array
    """(N + 1, 3n)"""
    inputs: Array
    """(N, n)"""


@compiled(**FAST)
def workspace(stages: int, n: int) -> Workspace:
    """Return uninitialised arrays for a problem with n inputs."""
    size = 3 * n
    return Workspace(
        np.empty((stages, n, size + 1)),
        np.empty((stages, n, n)),
        np.empty((stages, n, size)),
        np.empty((stages, n)),
        np.empty((size, size)),
        np.empty(size),
        np.empty((size, size)),
        np.empty(size),
        np.empty((stages + 1, size)),
        np.empty((stages, n)),
    )
