"""Solve an LqProblem by Riccati recursions inside a primal-dual active set.

Which bound each input lies on is guessed: free, on its upper or lower bound, or on its rate bound, where it
follows the acceleration: u = a + step. Given the guess the problem has only equalities, and one Riccati
recursion solves it in N steps of (3n)^3 at most (A_k is sparse: less), where condensing costs (N n)^3 and
building the condensed matrices N^2 more. Then the guess is mended: a free input beyond a bound is put on
it, one on a bound with a multiplier of the wrong sign is freed. The guess of the last tick is nearly right,
so one or two recursions suffice. Where mending all at once does not lead to fewer wrong guesses, they are
mended one by one, last first, which cannot cycle. Sources: Judice, Pires, Computers Oper. Res. 21 (1994),
block principal pivoting; Rao, Wright, Rawlings, JOTA 99 (1998), Riccati inside a QP of MPC.

    V_k(x) = x' P_k x + 2 p_k' x;   Quu = R + S + B' P B,   Qux = B' P A - S E,   Qu = B' (P c + p) - R u*
    free inputs  u = -Quu^-1 (Qux x + Qu);   multiplier of a bound  g = Quu u + Qux x + Qu

If the guess still changes after the last iteration, the last feedback u = K x + k is rolled out inside the
bounds: all bounds hold, and the answer says that it is not the optimum.
"""

import numpy as np
from numpy.typing import NDArray

from q2q_control.mpc.problem.lq_problem import LqProblem, LqSolution
from q2q_control.mpc.solver.active_set import FREE, HIGH, LOW, RISING, bounds_of, mend
from q2q_model.compiled import FAST, compiled
from q2q_model.signals.values import Array

PATIENCE = 3
"""How many recursions may pass without fewer wrong guesses before they are mended one by one."""


def solve(problem: LqProblem, guess: NDArray[np.int8] | None = None, iterations: int = 12) -> LqSolution:
    """Return the optimal states and inputs; `guess` is the pattern of a similar problem, (N, n)."""
    n = problem.input_gain.shape[0]
    pattern = np.zeros((problem.values.shape[0], n), np.int8) if guess is None else guess.copy()
    states, inputs, used, converged = solve_from(problem, pattern, iterations)
    return LqSolution(states, inputs, pattern, used, converged)


@compiled(**FAST)
def solve_from(
    problem: LqProblem, pattern: NDArray[np.int8], iterations: int
) -> tuple[Array, Array, int, bool]:
    """Return states, inputs, recursions used, whether they are optimal; update `pattern` (N, n) in place."""
    stages, n = pattern.shape
    size = 3 * n
    policy = np.empty((stages, n, size + 1))  # u = policy[:, :size] x + policy[:, size]
    quu, qux, qu = np.empty((stages, n, n)), np.empty((stages, n, size)), np.empty((stages, n))
    states, inputs = np.empty((stages + 1, size)), np.empty((stages, n))
    fewest, patience = pattern.size + 1, PATIENCE
    for iteration in range(iterations):
        _backward(problem, pattern, policy, (quu, qux, qu))
        _roll_out(problem, policy, (states, inputs), inside=False)
        wrong = mend(problem, pattern, (states, inputs), (quu, qux, qu), every=patience > 0)
        if wrong == 0:
            return states, inputs, iteration + 1, True
        patience = PATIENCE if wrong < fewest else patience - 1
        fewest = min(fewest, wrong)
    _roll_out(problem, policy, (states, inputs), inside=True)
    return states, inputs, iterations, False


@compiled(**FAST)
def _backward(
    problem: LqProblem,
    pattern: NDArray[np.int8],
    policy: Array,
    quadratics: tuple[Array, Array, Array],
) -> None:
    """Fill the policy and the quadratics of every stage, last to first."""
    stages, n = pattern.shape
    size = 3 * n
    value, slope = np.zeros((size, size)), np.zeros(size)  # P, p
    product, ahead = np.empty((size, size)), np.empty(size)  # P A, P c + p
    for c in range(n):
        for i in range(3):
            for j in range(3):
                value[3 * c + i, 3 * c + j] = problem.terminal[c, i, j]
                slope[3 * c + i] -= problem.terminal[c, i, j] * problem.target[stages, 3 * c + j]
    for k in range(stages - 1, -1, -1):
        _stage_quadratics(problem, k, (value, slope), (product, ahead), quadratics)
        _stage_policy(problem, k, pattern[k], policy[k], quadratics)
        _stage_value(problem, k, (value, slope), (product, ahead), (policy[k], quadratics))


@compiled(**FAST)
def _stage_quadratics(
    problem: LqProblem,
    k: int,
    future: tuple[Array, Array],
    scratch: tuple[Array, Array],
    quadratics: tuple[Array, Array, Array],
) -> None:
    value, slope = future
    product, ahead = scratch
    quu, qux, qu = quadratics[0][k], quadratics[1][k], quadratics[2][k]
    size, n = slope.size, problem.input_gain.shape[0]
    product[:] = 0.0
    for e in range(problem.rows.size):
        row, col, entry = problem.rows[e], problem.cols[e], problem.values[k, e]
        for i in range(size):
            product[col, i] += value[row, i] * entry  # rows of product are columns of P A
    for i in range(size):
        total = slope[i]
        for j in range(size):
            total += value[i, j] * problem.drift[k, j]
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
                through = b0 * value[p, 3 * d + j] + b1 * value[v, 3 * d + j] + b2 * value[a, 3 * d + j]
                total += through * gains[d, j]
            quu[c, d] = total
        effort, jerk = problem.input_weight[c, 0], problem.input_weight[c, 1]
        quu[c, c] += effort + jerk
        qux[c, a] -= jerk
        qu[c] = b0 * ahead[p] + b1 * ahead[v] + b2 * ahead[a] - effort * problem.input_target[k, c]


@compiled(**FAST)
def _stage_policy(
    problem: LqProblem,
    k: int,
    modes: NDArray[np.int8],
    policy: Array,
    quadratics: tuple[Array, Array, Array],
) -> None:
    """Fill the rows of the policy: what a bound says, or what the free inputs do about it."""
    quu, qux, qu = quadratics[0][k], quadratics[1][k], quadratics[2][k]
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
def _solve_free(factor: Array, modes: NDArray[np.int8], right: Array) -> None:
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
def _stage_value(
    problem: LqProblem,
    k: int,
    future: tuple[Array, Array],
    scratch: tuple[Array, Array],
    stage: tuple[Array, tuple[Array, Array, Array]],
) -> None:
    """Replace P, p of stage k + 1 by those of stage k."""
    value, slope = future
    product, ahead = scratch
    policy = stage[0]
    quu, qux, qu = stage[1][0][k], stage[1][1][k], stage[1][2][k]
    n, size = qu.size, slope.size
    value[:] = 0.0
    slope[:] = 0.0
    for e in range(problem.rows.size):
        row, col, entry = problem.rows[e], problem.cols[e], problem.values[k, e]
        slope[col] += entry * ahead[row]
        for i in range(size):
            value[col, i] += entry * product[i, row]  # A' (P A)
    for c in range(n):
        for i in range(3):
            weight = problem.state_weight[c, i]
            value[3 * c + i, 3 * c + i] += weight
            slope[3 * c + i] -= weight * problem.target[k, 3 * c + i]
        value[3 * c + 2, 3 * c + 2] += problem.input_weight[c, 1]
    for c in range(n):
        lean = qu[c]
        for d in range(n):
            lean += quu[c, d] * policy[d, size]
        for i in range(size):
            pull = qux[c, i]
            for d in range(n):
                pull += quu[c, d] * policy[d, i]
            slope[i] += policy[c, i] * lean + qux[c, i] * policy[c, size]
            for j in range(size):
                value[j, i] += policy[c, j] * pull + qux[c, j] * policy[c, i]


@compiled(**FAST)
def _roll_out(problem: LqProblem, policy: Array, path: tuple[Array, Array], inside: bool) -> None:
    """Fill states and inputs of the policy, the inputs cut at their bounds where `inside`."""
    states, inputs = path
    stages, n = inputs.shape
    states[0] = problem.start
    for k in range(stages):
        for c in range(n):
            wanted = policy[k, c, 3 * n]
            for i in range(3 * n):
                wanted += policy[k, c, i] * states[k, i]
            if inside:
                low, high = bounds_of(problem, k, c, states[k, 3 * c + 2])
                wanted = min(max(wanted, low), high)
            inputs[k, c] = wanted
            for i in range(3):
                pushed = problem.input_gain[c, i] * wanted
                states[k + 1, 3 * c + i] = problem.drift[k, 3 * c + i] + pushed
        for e in range(problem.rows.size):
            states[k + 1, problem.rows[e]] += problem.values[k, e] * states[k, problem.cols[e]]
