"""Keep pairs out of a zone by planes at samples, and bend a swarm as little as they allow.

A plane (i, j, s, n, level) asks n.(r_i(t_s) - r_j(t_s)) >= level. In the bends y of `deviation_space` all
planes together read A y >= b, and the least bend is y = A'x with the dual x >= 0 of least
1/2 x'AA'x - b'x. It is approached from a guess x_0 by proximal steps, with delta/2 ||x - x_0||^2 added,
which planes that contradict each other cannot break. Two planes touch each other in AA' only where they
share a vehicle, so AA' is sparse for a large swarm: few planes go to an interior point method, many to
coordinate descent (Hildreth, A quadratic programming procedure, 1957), one pass over AA' a sweep.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array
from q2q_planner.offline.avoidance.nonnegative_qp import solve_nonnegative_qp
from q2q_planner.offline.avoidance.swarm_samples import SwarmSamples

Rows = NDArray[np.intp]

HARD = 1e-4
"""Least delta, over the mean of AA' 's diagonal."""
MOST_DENSE = 400
"""Planes up to which AA' is treated as dense: its factor costs under 10 ms."""
SWEEPS = 2000
"""Most passes of coordinate descent."""
RELAXED = 1.7
"""Over-relaxation of coordinate descent, between 1 and 2: projected SOR (Cryer, 1971)."""
ACTIVE_SETS = 12
"""Most active sets tried to finish exactly."""
SETTLED = 1e-7
"""Coordinate descent ends when no plane gains more than this in a sweep [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class Planes:
    """m half-spaces."""

    first: Rows
    """Vehicle i, (m,)."""
    second: Rows
    """Vehicle j, (m,)."""
    sample: Rows
    """Row s of the samples, (m,)."""
    normal: Array
    """Unit normal n, (m, 3)."""
    level: Array
    """[m], (m,)."""


def least_bends(
    samples: SwarmSamples, planes: Planes, warm: Array, softness: float = HARD
) -> tuple[Array, Array]:
    """Return the bends y (n, m, 3) of least cost that meet the planes, and their dual x (planes,).

    `warm` is the guess x_0; `softness` is delta over the mean of AA' 's diagonal, HARD for few planes.
    """
    n, _, dimension = samples.rows.shape
    pushes = _push_matrix(samples, planes)
    rel = samples.base[planes.sample, planes.first] - samples.base[planes.sample, planes.second]
    asked = planes.level - (planes.normal * rel).sum(-1)
    dual = _dual(pushes, asked, warm, softness)
    bends = (pushes.T @ dual).reshape(n, 3, dimension).swapaxes(1, 2)
    return bends, dual


def _push_matrix(samples: SwarmSamples, planes: Planes) -> sparse.csr_array:
    """Return A, (planes, n * 3 * m)."""
    n, _, dimension = samples.rows.shape
    count = len(planes.sample)
    column = np.arange(3 * dimension)
    data, columns = [], []
    for vehicle, sign in ((planes.first, 1.0), (planes.second, -1.0)):
        phi = samples.rows[vehicle, planes.sample]  # (planes, m)
        data.append((sign * planes.normal[:, :, None] * phi[:, None, :]).reshape(count, -1))
        columns.append(vehicle[:, None] * (3 * dimension) + column)
    pointer = np.arange(count + 1) * (6 * dimension)
    flat = np.concatenate(data, axis=1).ravel(), np.concatenate(columns, axis=1).ravel(), pointer
    return sparse.csr_array(flat, shape=(count, n * 3 * dimension))


def _dual(pushes: sparse.csr_array, asked: Array, warm: Array, softness: float) -> Array:
    """Return the planes' dual, (planes,), from A and what each plane asks for beyond the unbent curves."""
    few = len(asked) <= MOST_DENSE
    if few:
        dense = pushes.toarray()
        gram = dense @ dense.T
    else:
        gram = (pushes @ pushes.T).tocsr()
    give = (HARD if few else softness) * gram.diagonal().mean()
    if give == 0.0:  # nothing can be moved
        return np.zeros_like(asked)
    if few:
        return solve_nonnegative_qp(gram + give * np.eye(len(asked)), asked + give * warm)
    soft = (gram + give * sparse.eye_array(len(asked))).tocsr()
    asked = asked + give * warm
    return settle_active_set(soft, asked, coordinate_descent(soft, asked, warm))


def coordinate_descent(gram: sparse.csr_array, asked: Array, warm: Array) -> Array:
    """Return argmin 1/2 x'Gx - b'x over x >= 0 for a sparse G with positive diagonal, from a guess."""
    dual = np.maximum(warm, 0.0)
    slack = gram @ dual - asked
    matrix = (gram.indptr, gram.indices, gram.data, gram.diagonal())
    _compiled_descent(matrix, dual, slack, SWEEPS, SETTLED)
    return dual


def settle_active_set(gram: sparse.csr_array, asked: Array, dual: Array) -> Array:
    """Return the exact minimiser next to a good guess: solve on the active planes until they stay the same.

    The primal-dual active set method (Hintermueller, Ito and Kunisch, 2002). Where it does not settle, the
    guess is returned.
    """
    diagonal = gram.diagonal()
    exact = dual
    active = dual > 0.0
    for _ in range(ACTIVE_SETS):
        rows = np.flatnonzero(active)
        exact = np.zeros_like(dual)
        exact[rows] = np.linalg.solve(gram[rows][:, rows].toarray(), asked[rows])
        slack = gram @ exact - asked
        now = np.where(active, exact > 0.0, slack < -1e-12 * diagonal.max())
        if (now == active).all():
            return np.maximum(exact, 0.0)
        active = now
    return dual


@compiled
def _compiled_descent(
    matrix: tuple[Rows, Rows, Array, Array], dual: Array, slack: Array, sweeps: int, settled: float
) -> None:
    """Minimise over one coordinate after the other; dual and slack = G x - b change in place."""
    pointer, column, value, diagonal = matrix
    for _ in range(sweeps):
        largest = 0.0
        for row in range(dual.size):
            change = max(-RELAXED * slack[row] / diagonal[row], -dual[row])
            if change == 0.0:
                continue
            dual[row] += change
            largest = max(largest, abs(change) * diagonal[row])
            for at in range(pointer[row], pointer[row + 1]):
                slack[column[at]] += value[at] * change
        if largest < settled:
            return
