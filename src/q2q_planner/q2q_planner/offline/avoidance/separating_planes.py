"""Least deformation of a swarm under separating planes at samples.

A plane (i, j, s, n, level) requires n.(r_i(t_s) - r_j(t_s)) >= level. In the deviations y of
`deviation_space` all planes together read A y >= b, and the least deviation is y = A'x, where the dual x >= 0
minimises 1/2 x'AA'x - b'x. It is approached from a guess x_0 by proximal steps, with delta/2 ||x - x_0||^2
added, so that contradictory planes do no harm. Two planes are coupled in AA' only if they share a vehicle, so
AA' is sparse for a large swarm: few planes are solved by an interior point method, many by coordinate descent
(Hildreth, A quadratic programming procedure, 1957), one pass over AA' per sweep.
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
"""Most planes for which AA' is treated as dense: its factor takes under 10 ms."""
SWEEPS = 2000
"""Most passes of coordinate descent."""
RELAXED = 1.7
"""Over-relaxation of coordinate descent, between 1 and 2: projected SOR (Cryer, 1971)."""
ACTIVE_SETS = 12
"""Most active sets tried for the exact solution."""
SETTLED = 1e-7
"""Largest change of a plane in a sweep at which coordinate descent ends [m]."""


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
    """Return the deviations y (n, m, 3) of least cost that satisfy the planes, and their dual x (planes,).

    `warm` is the guess x_0; `softness` is delta over the mean of AA' 's diagonal, HARD for few planes.
    """
    n, _, dimension = samples.rows.shape
    pushes = _push_matrix(samples, planes)
    rel = samples.base[planes.sample, planes.first] - samples.base[planes.sample, planes.second]
    required = planes.level - (planes.normal * rel).sum(-1)
    dual = _dual(pushes, required, warm, softness)
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


def _dual(pushes: sparse.csr_array, required: Array, warm: Array, softness: float) -> Array:
    """Return the planes' dual, (planes,), from A and b."""
    few = len(required) <= MOST_DENSE
    if few:
        dense = pushes.toarray()
        gram = dense @ dense.T
    else:
        gram = (pushes @ pushes.T).tocsr()
    give = (HARD if few else softness) * gram.diagonal().mean()
    if give == 0.0:  # no vehicle can move
        return np.zeros_like(required)
    if few:
        return solve_nonnegative_qp(gram + give * np.eye(len(required)), required + give * warm)
    soft = (gram + give * sparse.eye_array(len(required))).tocsr()
    required = required + give * warm
    return settle_active_set(soft, required, coordinate_descent(soft, required, warm))


def coordinate_descent(gram: sparse.csr_array, required: Array, warm: Array) -> Array:
    """Return argmin 1/2 x'Gx - b'x over x >= 0 for a sparse G with positive diagonal, from a guess."""
    dual = np.maximum(warm, 0.0)
    slack = gram @ dual - required
    matrix = (gram.indptr, gram.indices, gram.data, gram.diagonal())
    _compiled_descent(matrix, dual, slack, SWEEPS, SETTLED)
    return dual


def settle_active_set(gram: sparse.csr_array, required: Array, dual: Array) -> Array:
    """Return the exact minimiser next to a good guess: solve on the active planes until they do not change.

    The primal-dual active set method (Hintermueller, Ito and Kunisch, 2002). If it does not converge, the
    guess is returned.
    """
    diagonal = gram.diagonal()
    exact = dual
    active = dual > 0.0
    for _ in range(ACTIVE_SETS):
        rows = np.flatnonzero(active)
        exact = np.zeros_like(dual)
        exact[rows] = np.linalg.solve(gram[rows][:, rows].toarray(), required[rows])
        slack = gram @ exact - required
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
