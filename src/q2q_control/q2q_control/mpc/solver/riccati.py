"""Riccati recursion inside a primal-dual active set: the solver of an LqProblem.

The active set guesses the bound each input lies on: none, the upper or lower one, or a rate bound, where the
input follows the acceleration: u = a + step. With the guess fixed the problem has only equalities, and one
Riccati recursion solves it in N steps of at most (3n)^3 (less, because A_k is sparse); condensing would cost
(N n)^3, and N^2 for the matrices. Then the guess is updated: a free input beyond a bound is put on it, an
input on a bound with a multiplier of the wrong sign is freed. The pattern of the last tick is nearly right,
so one or two recursions suffice. If updating all inputs at once does not reduce the number of wrong guesses,
they are updated one by one, last first, which cannot cycle. Sources: Judice, Pires, Computers Oper. Res. 21
(1994), block principal pivoting; Rao, Wright, Rawlings, JOTA 99 (1998), Riccati inside a QP of MPC.

    V_k(x) = x' P_k x + 2 p_k' x;   Quu = R + S + B' P B,   Qux = B' P A - S E,   Qu = B' (P c + p) - R u*
    free inputs  u = -Quu^-1 (Qux x + Qu);   multiplier of a bound  g = Quu u + Qux x + Qu

If the guess still changes after the last iteration, the last feedback u = K x + k is rolled out and clipped
to the bounds: the solution then keeps all bounds and is marked as not converged.
"""

import numpy as np

from q2q_control.mpc.problem.lq_problem import LqProblem, LqSolution
from q2q_control.mpc.solver.active_set import (
    FREE,
    HIGH,
    LOW,
    RISING,
    Modes,
    input_range,
    update_active_set,
)
from q2q_control.mpc.solver.workspace import Workspace, workspace
from q2q_model.compiled import FAST, compiled
from q2q_model.signals.values import Array

PATIENCE = 3
"""Recursions without fewer wrong guesses before inputs are updated one by one."""


def solve(problem: LqProblem, guess: Modes | None = None, iterations: int = 12) -> LqSolution:
    """Return the optimal states and inputs; `guess` is the pattern of a similar problem, (N, n)."""
    shape = problem.values.shape[0], problem.input_gain.shape[0]
    return solve_from(problem, np.zeros(shape, np.int8) if guess is None else guess.copy(), iterations)


@compiled(**FAST)
def solve_from(problem: LqProblem, pattern: Modes, iterations: int) -> LqSolution:
    """Return the solution; `pattern` (N, n) holds the guess and is updated in place."""
    stages, n = pattern.shape
    work = workspace(stages, n)
    fewest, patience, wrong = pattern.size + 1, PATIENCE, 1
    for iteration in range(iterations):
        _backward(problem, pattern, work)
        _roll_out(problem, work, clipped=False)
        wrong = update_active_set(problem, pattern, work, every=patience > 0)
        if wrong == 0:
            return LqSolution(work.states, work.inputs, pattern, iteration + 1, wrong == 0)
        patience = PATIENCE if wrong < fewest else patience - 1
        fewest = min(fewest, wrong)
    _roll_out(problem, work, clipped=True)
    return LqSolution(work.states, work.inputs, pattern, iterations, wrong == 0)


@compiled(**FAST)
def _backward(problem: LqProblem, pattern: Modes, work: Workspace) -> None:
    """Write policy and quadratic forms of every stage, last to first."""
    stages, n = pattern.shape
    work.cost_matrix[:] = 0.0
    work.cost_vector[:] = 0.0
    for c in range(n):
        for i in range(3):
            for j in range(3):
                work.cost_matrix[3 * c + i, 3 * c + j] = problem.terminal[c, i, j]
                pull = problem.terminal[c, i, j] * problem.target[stages, 3 * c + j]
                work.cost_vector[3 * c + i] -= pull
    for k in range(stages - 1, -1, -1):
        _stage_quadratics(problem, k, work)
        _stage_policy(problem, k, pattern[k], work)
        _stage_cost(problem, k, work)


@compiled(**FAST)
def _stage_quadratics(problem: LqProblem, k: int, work: Workspace) -> None:
    """Write P A, P c + p and Quu, Qux, Qu of stage k."""
    P, product, ahead = work.cost_matrix, work.product, work.ahead
    quu, qux, qu = work.quu[k], work.qux[k], work.qu[k]
    size, n = ahead.size, qu.size
    product[:] = 0.0
    for e in range(problem.rows.size):
        row, col, entry = problem.rows[e], problem.cols[e], problem.values[k, e]
        for i in range(size):
            product[col, i] += P[row, i] * entry  # rows of product are columns of P A
    for i in range(size):
        total = work.cost_vector[i]
        for j in range(size):
            total += P[i, j] * problem.drift[k, j]
        ahead[i] = total
    gains = problem.input_gain
    for c in range(n):
        b0, b1, b2 = gains[c, 0], gains[c, 1], gains[c, 2]
        p, v, a = 3 * c, 3 * c + 1, 3 * c + 2
        for i in range(size):
            qux[c, i] = b0 * product[i, p] + b1 * product[i, v] + b2 * product[i, a]
        for d in range(n):
            total = 0.0
            for j in range(3):
                through = b0 * P[p, 3 * d + j] + b1 * P[v, 3 * d + j] + b2 * P[a, 3 * d + j]
                total += through * gains[d, j]
            quu[c, d] = total
        effort, jerk = problem.input_weight[c, 0], problem.input_weight[c, 1]
        quu[c, c] += effort + jerk
        qux[c, a] -= jerk
        qu[c] = b0 * ahead[p] + b1 * ahead[v] + b2 * ahead[a] - effort * problem.input_target[k, c]


@compiled(**FAST)
def _stage_policy(problem: LqProblem, k: int, modes: Modes, work: Workspace) -> None:
    """Write the policy of stage k: bounds of the active inputs, and the free inputs' response to them."""
    policy, quu, qux, qu = work.policy[k], work.quu[k], work.qux[k], work.qu[k]
    n, size = qu.size, 3 * qu.size
    for c in range(n):
        bound = modes[c] != FREE
        for i in range(size):
            policy[c, i] = 0.0 if bound else -qux[c, i]
        policy[c, size] = -qu[c]
        if modes[c] == HIGH:
            policy[c, size] = problem.high[k, c]
        elif modes[c] == LOW:
            policy[c, size] = problem.low[k, c]
        elif bound:
            policy[c, 3 * c + 2] = 1.0
            policy[c, size] = problem.step[c] if modes[c] == RISING else -problem.step[c]
    for c in range(n):
        for d in range(n):
            if modes[c] == FREE and modes[d] != FREE:
                for i in range(size + 1):
                    policy[c, i] -= quu[c, d] * policy[d, i]
    _solve_free(quu.copy(), modes, policy)


@compiled(**FAST)
def _solve_free(factor: Array, modes: Modes, right: Array) -> None:
    """Overwrite the free rows of `right` by factor_ff^-1 times them; `factor` is positive definite."""
    n = modes.size
    for a in range(n):
        for b in range(a + 1):
            if modes[a] != FREE or modes[b] != FREE:
                factor[a, b] = 1.0 if a == b else 0.0
                continue
            total = factor[a, b]
            for c in range(b):
                total -= factor[a, c] * factor[b, c]
            factor[a, b] = np.sqrt(total) if a == b else total / factor[b, b]
    for i in range(right.shape[1]):
        for a in range(n):
            for c in range(a):
                right[a, i] -= factor[a, c] * right[c, i]
            right[a, i] /= factor[a, a]
        for a in range(n - 1, -1, -1):
            for c in range(a + 1, n):
                right[a, i] -= factor[c, a] * right[c, i]
            right[a, i] /= factor[a, a]


@compiled(**FAST)
def _stage_cost(problem: LqProblem, k: int, work: Workspace) -> None:
    """Replace P, p of stage k + 1 by those of stage k."""
    P, p, product, policy = work.cost_matrix, work.cost_vector, work.product, work.policy[k]
    quu, qux, qu = work.quu[k], work.qux[k], work.qu[k]
    n, size = qu.size, p.size
    P[:] = 0.0
    p[:] = 0.0
    for e in range(problem.rows.size):
        row, col, entry = problem.rows[e], problem.cols[e], problem.values[k, e]
        p[col] += entry * work.ahead[row]
        for i in range(size):
            P[col, i] += entry * product[i, row]  # A' (P A)
    for c in range(n):
        for i in range(3):
            weight = problem.state_weight[c, i]
            P[3 * c + i, 3 * c + i] += weight
            p[3 * c + i] -= weight * problem.target[k, 3 * c + i]
        P[3 * c + 2, 3 * c + 2] += problem.input_weight[c, 1]
    for c in range(n):
        lean = qu[c]
        for d in range(n):
            lean += quu[c, d] * policy[d, size]
        for i in range(size):
            pull = qux[c, i]
            for d in range(n):
                pull += quu[c, d] * policy[d, i]
            p[i] += policy[c, i] * lean + qux[c, i] * policy[c, size]
            for j in range(size):
                P[j, i] += policy[c, j] * pull + qux[c, j] * policy[c, i]


@compiled(**FAST)
def _roll_out(problem: LqProblem, work: Workspace, clipped: bool) -> None:
    """Write states and inputs under the policy, the inputs clipped to their bounds where `clipped`."""
    states, inputs, policy = work.states, work.inputs, work.policy
    stages, n = inputs.shape
    states[0] = problem.start
    for k in range(stages):
        for c in range(n):
            u = policy[k, c, 3 * n]
            for i in range(3 * n):
                u += policy[k, c, i] * states[k, i]
            if clipped:
                low, high = input_range(problem, k, c, states[k, 3 * c + 2])
                u = min(max(u, low), high)
            inputs[k, c] = u
            for i in range(3):
                pushed = problem.input_gain[c, i] * u
                states[k + 1, 3 * c + i] = problem.drift[k, 3 * c + i] + pushed
        for e in range(problem.rows.size):
            states[k + 1, problem.rows[e]] += problem.values[k, e] * states[k, problem.cols[e]]
