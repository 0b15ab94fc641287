"""Minimum deformation of a swarm under separating planes at samples.

A plane (i, j, s, n, level) requires n.(r_i(t_s) - r_j(t_s)) >= level. In the deviations y of
`deviation_space` all planes together read A y >= b, and the least deviation is y = A'x, where the dual x >= 0
minimises 1/2 x'AA'x - b'x. It is approached from a guess x_0 by proximal steps, with delta/2 ||x - x_0||^2
added. The step's y satisfies A y >= b - delta (x - x_0): where planes contradict each other, the step falls
short of them by that much, where without the term x would grow without bound. Two planes are coupled in AA'
only if they share a vehicle, so AA' is sparse for a large swarm. PIQP solves it (Schwan, Jiang, Kuhn, Jones,
PIQP: A proximal interior-point quadratic programming solver, 2023).
"""

import numpy as np
import piqp
from scipy import sparse

from q2q_model.signals.values import Array
from q2q_planner.offline.avoidance.separating_planes import Planes
from q2q_planner.offline.avoidance.swarm_samples import SwarmSamples

HARD = 1e-6
"""Minimum delta, over the mean of AA' 's diagonal: more lets planes of neighbouring samples settle slowly."""
MOST_DENSE = 400
"""Most planes for which AA' is treated as dense: its factor takes under 10 ms."""
ACCURACY = 1e-10
"""Absolute and relative tolerance of the QP, whose b has a largest entry of 1."""
UNITS = (1.0, HARD)
"""Units of G in which the QP is solved, over its mean diagonal: the second one where planes nearly contradict
each other, as a dual of 1 / HARD in the first one counts as without bound."""
LOOSE = 1e-6
"""Share of the largest dual below which a plane is loose: an interior point comes near zero but not to it."""


def least_deviations(
    samples: SwarmSamples, planes: Planes, warm: Array, softness: float = HARD
) -> tuple[Array, Array]:
    """Return the deviations y (n, m, 3) of minimum cost that satisfy the planes, and their dual x (planes,).

    The dual is zero for planes that are not touched. `warm` is the guess x_0; `softness` is delta over the
    mean of AA' 's diagonal, HARD for few planes.
    """
    n, _, dimension = samples.rows.shape
    if not len(planes.sample):  # the violation lies between samples
        return np.zeros((n, dimension, 3)), np.zeros(0)
    pushes = _push_matrix(samples, planes)
    rel = samples.base[planes.sample, planes.first] - samples.base[planes.sample, planes.second]
    required = planes.level - (planes.normal * rel).sum(-1)
    dual = _dual(pushes, required, warm, softness)
    deviations = (pushes.T @ dual).reshape(n, 3, dimension).swapaxes(1, 2)
    return deviations, np.where(dual > LOOSE * dual.max(initial=0.0), dual, 0.0)


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
    few, gram = len(required) <= MOST_DENSE, (pushes @ pushes.T).tocsr()
    give = (HARD if few else softness) * gram.diagonal().mean()
    if give == 0.0:  # no vehicle can move
        return np.zeros_like(required)
    gram = gram + give * sparse.eye_array(len(required))
    return nonnegative_qp(gram.toarray() if few else gram, required + give * warm)


def nonnegative_qp(gram: Array | sparse.csr_array, required: Array) -> Array:
    """Return argmin 1/2 x'Gx - b'x over x >= 0, (m,), for a positive definite G (m, m).

    Units cancel: in a flight of T seconds, G is in proportion to T^7. Unsolved, it is the last iterate: what
    comes of it is certified all the same.
    """
    if not (required > 0.0).any():
        return np.zeros_like(required)
    mean, most = gram.diagonal().mean(), np.abs(required).max()
    for unit in UNITS:
        dual, solved = _solved(gram / (unit * mean), required / most)
        if solved:
            break
    return np.asarray(dual * (most / (unit * mean)), dtype=np.float64)


def _solved(gram: Array | sparse.csr_array, required: Array) -> tuple[Array, bool]:
    """Return the solution of `nonnegative_qp`, and whether it is one."""
    dense = isinstance(gram, np.ndarray)
    solver = piqp.DenseSolver() if dense else piqp.SparseSolver()
    solver.settings.eps_abs = solver.settings.eps_rel = ACCURACY
    matrix = gram if dense else sparse.csc_matrix(gram)
    solver.setup(matrix, -required, x_l=np.zeros_like(required))
    status = solver.solve()
    return np.maximum(solver.result.x, 0.0), status == piqp.PIQP_SOLVED
