"""Linear-quadratic optimal control problem with bounded inputs, in the form its solver reads.

    minimise    sum_k  |x_k - x*_k|^2_Q + R (u_k - u*_k)^2 + S (u_k - a_k)^2   + |x_N - x*_N|^2_P
    subject to  x_{k+1} = A_k x_k + B u_k + c_k,   A_k = A + D G_k E,   x_0 given
                low_k <= u_k <= high_k,   |u_k - a_k| <= slew_max

Each input has an axis of three states: position, velocity, and the acceleration a that follows the input with
a lag. A bound on u - a thus limits the rate of thrust or tilt, and its weight S penalises jerk. Where the
acceleration is so far outside low and high that both bounds cannot hold, that of the rate yields. Everything
is block diagonal over the axes but G_k, by which the positions E x of all axes push each one. The A of an
axis is an upper triangle whose first two diagonal entries are 1.

Problem and solution are NamedTuples, which compiled code can take.

| symbol | name | meaning [unit] |
|---|---|---|
| N, n | | stages, axes of all vehicles (one input each); the state has 3 n entries |
| A | transition | of each axis |
| D | push_gain | of each axis: position [s^2], velocity [s] per acceleration |
| G_k | gradient | acceleration of one axis per position of another [1/s^2] |
| B | input_gain | of each axis: position [s^2], velocity [s], acceleration [-] per input |
| u | input | commanded acceleration [m/s^2] |
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from q2q_model.signals.values import Array


class LqProblem(NamedTuple):
    """Linear-quadratic problem with input bounds; stage index first."""

    start: Array
    """x_0, (3n,)."""
    transition: Array
    """A, (n, 3, 3)."""
    push_gain: Array
    """D, (n, 3); the acceleration's is 0."""
    gradient: Array
    """G_k, (N, n, n): row feels, column moves."""
    drift: Array
    """c_k, (N, 3n)."""
    input_gain: Array
    """B, (n, 3)."""
    state_weight: Array
    """Q, (n, 3): position, velocity, acceleration."""
    terminal: Array
    """P, (n, 3, 3)."""
    target: Array
    """x*_k, (N + 1, 3n)."""
    input_weight: Array
    """R and S, (n, 2)."""
    input_target: Array
    """u*_k, (N, n)."""
    low: Array
    """(N, n) [m/s^2]."""
    high: Array
    """(N, n) [m/s^2]."""
    slew_max: Array
    """Largest difference of u and a [m/s^2], (n,); infinite where the rate is not limited."""


class LqSolution(NamedTuple):
    """Optimal inputs and states."""

    states: Array
    """(N + 1, 3n)"""
    inputs: Array
    """(N, n)"""
    active_set: NDArray[np.int8]
    """Bound of each input (q2q_control.mpc.solver.active_set), (N, n): the next solve's warm start."""
    iterations: int
    converged: bool
    """False: the inputs keep all bounds but are not optimal.

    True: the optimum, unless the rate's bound yields at a stage. Where low or high change from stage to
    stage, inputs that change earlier might keep all bounds then; they are not looked for.
    """


def dense_matrices(problem: LqProblem) -> Array:
    """Return A_k, (N, 3n, 3n)."""
    stages, n = problem.low.shape
    dense = np.zeros((stages, 3 * n, 3 * n))
    for c in range(n):
        own = slice(3 * c, 3 * c + 3)
        dense[:, own, own] = problem.transition[c]
    for c in range(n):
        dense[:, 3 * c : 3 * c + 3, ::3] += problem.push_gain[c, :, None] * problem.gradient[:, c, None, :]
    return dense


def input_matrix(problem: LqProblem) -> Array:
    """Return B, (3n, n)."""
    n = problem.input_gain.shape[0]
    matrix = np.zeros((3 * n, n))
    for c in range(n):
        matrix[3 * c : 3 * c + 3, c] = problem.input_gain[c]
    return matrix


def cost(problem: LqProblem, states: Array, inputs: Array) -> float:
    """Return the objective at states (N + 1, 3n) and inputs (N, n)."""
    n = problem.input_gain.shape[0]
    error = states - problem.target
    stage = (error[:-1] ** 2 @ problem.state_weight.ravel()).sum()
    last = error[-1].reshape(n, 3)
    terminal = np.einsum("ni,nij,nj->", last, problem.terminal, last)  # sum over axes of e' P e
    effort = ((inputs - problem.input_target) ** 2 @ problem.input_weight[:, 0]).sum()
    jerk = ((inputs - states[:-1, 2::3]) ** 2 @ problem.input_weight[:, 1]).sum()
    return float(stage + terminal + effort + jerk)
