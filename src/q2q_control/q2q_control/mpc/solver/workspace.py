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
    """P, (N + 1, 3n, 3n)."""
    cost_vector: Array
    """p, (N + 1, 3n)."""
    product: Array
    """P A of the stage ahead, (3n, 3n)."""
    ahead: Array
    """P c + p of the stage ahead, (3n,)."""
    factor: Array
    """Cholesky factor of Quu, (n, n), with the inverse of its diagonal."""
    states: Array
    """(N + 1, 3n)"""
    inputs: Array
    """(N, n)"""


@compiled(**FAST)
def workspace(stages: int, n: int) -> Workspace:
    """Return uninitialised arrays for a problem with N = `stages` stages and n inputs."""
    size = 3 * n
    return Workspace(
        policy=np.empty((stages, n, size + 1)),
        quu=np.empty((stages, n, n)),
        qux=np.empty((stages, n, size)),
        qu=np.empty((stages, n)),
        cost_matrix=np.empty((stages + 1, size, size)),
        cost_vector=np.empty((stages + 1, size)),
        product=np.empty((size, size)),
        ahead=np.empty(size),
        factor=np.empty((n, n)),
        states=np.empty((stages + 1, size)),
        inputs=np.empty((stages, n)),
    )
