"""Riccati recursion inside a primal-dual active set: the solver of an LqProblem.

The active set is the bound that each input is assumed to lie on: none, the upper or lower one, or a rate
bound, where the input follows the acceleration: u = a + slew_max. With the active set fixed the problem has
only equalities, and one Riccati recursion solves it in N steps of at most (3n)^3 (less, because A_k is
sparse); condensing would cost (N n)^3, and N^2 for the matrices. Then the active set is updated: a free input
beyond a bound is put on it, an input on a bound with a multiplier of the wrong sign is freed. The last
tick's, as a warm start, is nearly right, so one or two recursions suffice. If updating all inputs at once
does not reduce the number of wrong bounds, they are updated one by one, last first. With bounds of inputs
alone this cannot cycle; where many rate bounds bind, which depend on the state, it can. MpcParams allows no
rates at which that is frequent at the default bandwidth_z. A faster loop meets more bounds: at 12 rad/s, to
which `correct` raises it, 68 % of random problems without a warm start are solved in the default 12
recursions at the default rate (51 % at the least one allowed), and 90 % in 30 (70 %). Sources: Judice, Pires,
Computers Oper. Res. 21 (1994), block principal pivoting; Rao, Wright, Rawlings, JOTA 99 (1998), Riccati
inside a QP of MPC.

    V_k(x) = x' P_k x + 2 p_k' x;   Quu = R + S + B' P B,   Qux = B' P A - S E,   Qu = B' (P c + p) - R u*
    free inputs  u = -Quu^-1 (Qux x + Qu);   multiplier of a bound  g = Quu u + Qux x + Qu

The recursion runs backward, so an active set that changes at stage k and before leaves P and p behind k as
they are: the next recursion begins at k. If it still changes after the last iteration, the last feedback
u = K x + k is rolled out and clipped to the bounds: the solution then keeps all bounds and is marked as not
converged.
"""

import numpy as np

from q2q_control.mpc.problem.lq_problem import LqProblem, LqSolution
from q2q_control.mpc.solver.active_set import ActiveSet, input_range, update_active_set
from q2q_control.mpc.solver.stage import last_cost, stage_cost, stage_policy, stage_product, stage_quadratics
from q2q_control.mpc.solver.workspace import Workspace, workspace
from q2q_model.compiled import BORROWING, FAST, FAST_HOT, compiled

PATIENCE = 10
"""Recursions without fewer wrong bounds before inputs are updated one by one."""


def solve(problem: LqProblem, warm_start: ActiveSet | None = None, iterations: int = 12) -> LqSolution:
    """Return the optimal states and inputs; `warm_start` is the active set of a similar one, (N, n)."""
    shape = problem.low.shape
    return solve_from(
        problem, np.zeros(shape, np.int8) if warm_start is None else warm_start.copy(), iterations
    )


@compiled(**FAST)
def solve_from(problem: LqProblem, active_set: ActiveSet, iterations: int) -> LqSolution:
    """Return the solution; `active_set` (N, n) is the warm start, and is updated in place."""
    stages, n = active_set.shape
    work = workspace(stages, n)
    fewest, patience, wrong, changed = active_set.size + 1, PATIENCE, 1, stages - 1
    for iteration in range(iterations):
        _recursion(problem, active_set, work, changed)
        wrong, changed = update_active_set(problem, active_set, work, every=patience > 0)
        if wrong == 0:
            return LqSolution(work.states, work.inputs, active_set, iteration + 1, wrong == 0)
        patience = PATIENCE if wrong < fewest else patience - 1
        fewest = min(fewest, wrong)
    _roll_out_clipped(problem, work)
    return LqSolution(work.states, work.inputs, active_set, iterations, wrong == 0)


@compiled(**FAST, **BORROWING)
def _recursion(problem: LqProblem, active_set: ActiveSet, work: Workspace, last: int) -> None:
    """Write policy and quadratic forms from stage `last` to the first one, then states and inputs.

    The number of axes is a constant for one and for a pair, whose loops are unrolled: half the time. More
    cases would double the time to compile, and solves of more vehicles are a small part of a swarm's tick.
    """
    n = active_set.shape[1]
    if n == 1:
        _backward(problem, active_set, work, (last, 1))
        _roll_out(problem, work, 1)
    elif n == 2:
        _backward(problem, active_set, work, (last, 2))
        _roll_out(problem, work, 2)
    else:
        _backward(problem, active_set, work, (last, n))
        _roll_out(problem, work, n)


@compiled(**FAST_HOT)
def _backward(problem: LqProblem, active_set: ActiveSet, work: Workspace, last_n: tuple[int, int]) -> None:
    """Write policy and quadratic forms of the stages from `last` to the first one."""
    last, n = last_n
    if last == active_set.shape[0] - 1:
        last_cost(problem, work, n)
    for k in range(last, -1, -1):
        stage_product(problem, k, work, n)
        stage_quadratics(problem, k, work, n)
        stage_policy(problem, k, active_set[k], work, n)
        stage_cost(problem, k, work, n)


@compiled(**FAST_HOT)
def _roll_out(problem: LqProblem, work: Workspace, n: int) -> None:
    """Write states and inputs under the policy."""
    for i in range(3 * n):
        work.states[0, i] = problem.start[i]
    for k in range(work.inputs.shape[0]):
        for c in range(n):
            u = work.policy[k, c, 3 * n]
            for i in range(3 * n):
                u += work.policy[k, c, i] * work.states[k, i]
            work.inputs[k, c] = u
        write_next_state(problem, k, work, n)


@compiled(**FAST)
def _roll_out_clipped(problem: LqProblem, work: Workspace) -> None:
    """Write states and inputs under the policy, the inputs clipped to their bounds."""
    stages, n = work.inputs.shape
    for k in range(stages):
        for c in range(n):
            u = work.policy[k, c, 3 * n]
            for i in range(3 * n):
                u += work.policy[k, c, i] * work.states[k, i]
            low, high = input_range(problem, k, c, work.states[k, 3 * c + 2])
            work.inputs[k, c] = min(max(u, low), high)
        write_next_state(problem, k, work, n)


@compiled(**FAST_HOT)
def write_next_state(problem: LqProblem, k: int, work: Workspace, n: int) -> None:
    """Write the state (3n,) after stage k, of its state and inputs (n,) in `work`."""
    before, after, drift = work.states[k], work.states[k + 1], problem.drift[k]
    for c in range(n):
        push = 0.0
        for d in range(n):
            push += problem.gradient[k, c, d] * before[3 * d]
        A, u, at = problem.transition[c], work.inputs[k, c], 3 * c
        for row in range(3):
            after[at + row] = (
                drift[at + row] + problem.input_gain[c, row] * u + problem.push_gain[c, row] * push
            )
            for column in range(row, 3):
                after[at + row] += A[row, column] * before[at + column]
