"""One stage of the Riccati recursion of q2q_control.mpc.solver.riccati, compiled into its loop.

With A_k = A + D G_k E (q2q_control.mpc.problem.lq_problem), A an upper triangle per axis, D its push gain
and E the positions:

    (P A_k) column p of axis d:  P_pd + sum_c (P D)_c G_k,cd       v: a_pv P_pd + P_vd       a: likewise
    P_k = A_k' (P A_k) + Q + K' Qux + Qux' K + K' Quu K             upper triangle, then mirrored
    p_k = A_k' (P c + p) - Q x* + K' (Qu + Quu k) + Qux' k

All arrays but the problem's are those of a Workspace: P, p its cost_matrix, cost_vector at a stage.
All functions are inlined, with `n` axes as an argument: for a constant `n` LLVM unrolls all loops.
"""

import numpy as np

from q2q_control.mpc.problem.lq_problem import LqProblem
from q2q_control.mpc.solver.active_set import FREE, HIGH, LOW, RISING, ActiveSet
from q2q_control.mpc.solver.workspace import Workspace
from q2q_model.compiled import FAST_HOT, compiled
from q2q_model.signals.values import Array


@compiled(**FAST_HOT)
def last_cost(problem: LqProblem, work: Workspace, n: int) -> None:
    """Write P (3n, 3n), p (3n,) of the horizon's end."""
    stages = work.inputs.shape[0]
    matrix, vector = work.cost_matrix[stages], work.cost_vector[stages]
    matrix[:] = 0.0
    vector[:] = 0.0
    for c in range(n):
        for i in range(3):
            for j in range(3):
                matrix[3 * c + i, 3 * c + j] = problem.terminal[c, i, j]
                vector[3 * c + i] -= problem.terminal[c, i, j] * problem.target[stages, 3 * c + j]


@compiled(**FAST_HOT)
def stage_product(problem: LqProblem, k: int, work: Workspace, n: int) -> None:
    """Write P A (3n, 3n) and P c + p (3n,) of stage k, with P, p of the stage after it."""
    P, p, product = work.cost_matrix[k + 1], work.cost_vector[k + 1], work.product
    gain, gradient, drift = problem.push_gain, problem.gradient[k], problem.drift[k]
    for i in range(3 * n):
        total = p[i]
        for j in range(3 * n):
            total += P[i, j] * drift[j]
        work.ahead[i] = total
        for d in range(n):
            A, at = problem.transition[d], 3 * d
            product[i, at] = P[i, at]
            product[i, at + 1] = A[0, 1] * P[i, at] + P[i, at + 1]
            product[i, at + 2] = A[0, 2] * P[i, at] + A[1, 2] * P[i, at + 1] + A[2, 2] * P[i, at + 2]
        for c in range(n):
            pushed = P[i, 3 * c] * gain[c, 0] + P[i, 3 * c + 1] * gain[c, 1]
            for d in range(n):
                product[i, 3 * d] += pushed * gradient[c, d]


@compiled(**FAST_HOT)
def stage_quadratics(problem: LqProblem, k: int, work: Workspace, n: int) -> None:
    """Write Quu (n, n), Qux (n, 3n), Qu (n,) of stage k."""
    P, product, ahead, gains = work.cost_matrix[k + 1], work.product, work.ahead, problem.input_gain
    quu, qux, qu = work.quu[k], work.qux[k], work.qu[k]
    for c in range(n):
        b0, b1, b2 = gains[c, 0], gains[c, 1], gains[c, 2]
        p, v, a = 3 * c, 3 * c + 1, 3 * c + 2
        for d in range(n):
            total = 0.0
            for j in range(3 * d, 3 * d + 3):
                qux[c, j] = b0 * product[p, j] + b1 * product[v, j] + b2 * product[a, j]
                total += (b0 * P[p, j] + b1 * P[v, j] + b2 * P[a, j]) * gains[d, j - 3 * d]
            quu[c, d] = total
        effort, jerk = problem.input_weight[c, 0], problem.input_weight[c, 1]
        quu[c, c] += effort + jerk
        qux[c, a] -= jerk
        qu[c] = b0 * ahead[p] + b1 * ahead[v] + b2 * ahead[a] - effort * problem.input_target[k, c]


@compiled(**FAST_HOT)
def stage_policy(problem: LqProblem, k: int, active_set: ActiveSet, work: Workspace, n: int) -> None:
    """Write the policy (n, 3n + 1) of stage k: bounds of the active inputs, and the free inputs' response.

    `active_set` (n,) is that of the stage.
    """
    policy, quu = work.policy[k], work.quu[k]
    _write_bounds(problem, k, active_set, work, n)
    for c in range(n):
        for d in range(n):
            if active_set[c] == FREE and active_set[d] != FREE:
                for i in range(3 * n + 1):
                    policy[c, i] -= quu[c, d] * policy[d, i]
    _factorise(quu, active_set, work.factor, n)
    for i in range(3 * n + 1):
        _substitute(work.factor, policy, i, n)


@compiled(**FAST_HOT)
def _write_bounds(problem: LqProblem, k: int, active_set: ActiveSet, work: Workspace, n: int) -> None:
    """Write the policy of active inputs, and -Qux and -Qu of free ones."""
    policy, qux, qu = work.policy[k], work.qux[k], work.qu[k]
    for c in range(n):
        bound = active_set[c] != FREE
        for i in range(3 * n):
            policy[c, i] = 0.0 if bound else -qux[c, i]
        policy[c, 3 * n] = -qu[c]
        if active_set[c] == HIGH:
            policy[c, 3 * n] = problem.high[k, c]
        elif active_set[c] == LOW:
            policy[c, 3 * n] = problem.low[k, c]
        elif bound:
            policy[c, 3 * c + 2] = 1.0
            policy[c, 3 * n] = problem.slew_max[c] if active_set[c] == RISING else -problem.slew_max[c]


@compiled(**FAST_HOT)
def _factorise(matrix: Array, active_set: ActiveSet, factor: Array, n: int) -> None:
    """Write the Cholesky factor of the free rows of `matrix`, elsewhere that of the identity.

    The diagonal of `factor` holds inverses.
    """
    for a in range(n):
        for b in range(a + 1):
            total = 1.0 if a == b else 0.0
            if active_set[a] == FREE and active_set[b] == FREE:
                total = matrix[a, b]
                for c in range(b):
                    total -= factor[a, c] * factor[b, c]
            factor[a, b] = 1.0 / np.sqrt(total) if a == b else total * factor[b, b]


@compiled(**FAST_HOT)
def _substitute(factor: Array, right: Array, i: int, n: int) -> None:
    """Overwrite column i of `right` by the solution of factor factor' x = right."""
    for a in range(n):
        total = right[a, i]
        for c in range(a):
            total -= factor[a, c] * right[c, i]
        right[a, i] = total * factor[a, a]
    for b in range(n):
        a = n - 1 - b
        total = right[a, i]
        for c in range(a + 1, n):
            total -= factor[c, a] * right[c, i]
        right[a, i] = total * factor[a, a]


@compiled(**FAST_HOT)
def stage_cost(problem: LqProblem, k: int, work: Workspace, n: int) -> None:
    """Write P (3n, 3n), p (3n,) of stage k."""
    P, p, product, ahead = work.cost_matrix[k], work.cost_vector[k], work.product, work.ahead
    gain, gradient = problem.push_gain, problem.gradient[k]
    for c in range(n):
        A, at = problem.transition[c], 3 * c
        for j in range(at, 3 * n):
            total = product[at, j]
            for d in range(n):
                pushed = gain[d, 0] * product[3 * d, j] + gain[d, 1] * product[3 * d + 1, j]
                total += gradient[d, c] * pushed
            P[at, j] = total
            P[at + 1, j] = A[0, 1] * product[at, j] + product[at + 1, j]
            P[at + 2, j] = (
                A[0, 2] * product[at, j] + A[1, 2] * product[at + 1, j] + A[2, 2] * product[at + 2, j]
            )
        total = ahead[at]
        for d in range(n):
            total += gradient[d, c] * (gain[d, 0] * ahead[3 * d] + gain[d, 1] * ahead[3 * d + 1])
        p[at] = total
        p[at + 1] = A[0, 1] * ahead[at] + ahead[at + 1]
        p[at + 2] = A[0, 2] * ahead[at] + A[1, 2] * ahead[at + 1] + A[2, 2] * ahead[at + 2]
        for i in range(3):
            P[at + i, at + i] += problem.state_weight[c, i]
            p[at + i] -= problem.state_weight[c, i] * problem.target[k, at + i]
        P[at + 2, at + 2] += problem.input_weight[c, 1]
    _add_policy_cost(k, work, n)


@compiled(**FAST_HOT)
def _add_policy_cost(k: int, work: Workspace, n: int) -> None:
    """Add what the inputs of stage k cost to P, p; mirror P."""
    P, p, policy = work.cost_matrix[k], work.cost_vector[k], work.policy[k]
    quu, qux, qu = work.quu[k], work.qux[k], work.qu[k]
    for c in range(n):
        lean = qu[c]
        for d in range(n):
            lean += quu[c, d] * policy[d, 3 * n]
        for i in range(3 * n):
            pull = qux[c, i]
            for d in range(n):
                pull += quu[c, d] * policy[d, i]
            p[i] += policy[c, i] * lean + qux[c, i] * policy[c, 3 * n]
            for j in range(i + 1):
                P[j, i] += policy[c, j] * pull + qux[c, j] * policy[c, i]
    for i in range(3 * n):
        for j in range(i):
            P[i, j] = P[j, i]
