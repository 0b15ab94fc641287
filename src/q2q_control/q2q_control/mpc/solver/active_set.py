"""Active set of an LqProblem: the bound that each input lies on, updated after a solve with it.

An input that crosses a bound is put on it. An input on a bound is freed where its multiplier has the wrong
sign, so that leaving the bound lowers the cost. An entry is free, on high, on low, rising or falling as fast
as the rate allows (u = a + slew_max, u = a - slew_max).
"""

import numpy as np
from numpy.typing import NDArray

from q2q_control.mpc.problem.lq_problem import LqProblem
from q2q_control.mpc.solver.workspace import Workspace
from q2q_model.compiled import FAST, compiled

ActiveSet = NDArray[np.int8]
"""Bound that each input lies on: FREE to FALLING."""

FREE, HIGH, LOW, RISING, FALLING = 0, 1, 2, 3, 4
"""Bound that an input lies on: none, on high, on low, on a + slew_max, on a - slew_max."""

_TOLERANCE = 1e-9
"""Violation of a bound [m/s^2], or multiplier of the wrong sign, below which nothing changes."""


@compiled(**FAST)
def input_range(problem: LqProblem, k: int, c: int, acc: float) -> tuple[float, float]:
    """Return the range of input c of stage k at acceleration `acc` [m/s^2].

    It is the nearer of low and high where the rate leads to neither: its bound yields (LqSolution.converged).
    """
    low, high = problem.low[k, c], problem.high[k, c]
    return min(max(low, acc - problem.slew_max[c]), high), max(min(high, acc + problem.slew_max[c]), low)


@compiled(**FAST)
def update_active_set(
    problem: LqProblem, active_set: ActiveSet, work: Workspace, every: bool
) -> tuple[int, int]:
    """Return how many inputs have the wrong bound and the last stage of one; correct `active_set` (N, n).

    All of them are corrected where `every`, else the last one only.
    """
    stages, n = active_set.shape
    wrong, last_k, last_c, last_bound = 0, 0, 0, FREE
    for k in range(stages):
        for c in range(n):
            multiplier = 0.0
            if active_set[k, c] != FREE:
                multiplier = work.qu[k, c]
                for d in range(n):
                    multiplier += work.quu[k, c, d] * work.inputs[k, d]
                for i in range(3 * n):
                    multiplier += work.qux[k, c, i] * work.states[k, i]
            allowed = input_range(problem, k, c, work.states[k, 3 * c + 2])
            limits = (problem.low[k, c], problem.high[k, c])
            bound = _corrected(active_set[k, c], work.inputs[k, c], multiplier, allowed, limits)
            if bound != active_set[k, c]:
                wrong, last_k, last_c, last_bound = wrong + 1, k, c, bound
                if every:
                    active_set[k, c] = bound
    if wrong > 0:
        active_set[last_k, last_c] = last_bound
    return wrong, last_k


@compiled(**FAST)
def _corrected(
    bound: int, value: float, multiplier: float, allowed: tuple[float, float], limits: tuple[float, float]
) -> int:
    """Return the right bound of an input; `allowed` is its range with the rate's bounds, `limits` without."""
    low, high = allowed
    if value > high + _TOLERANCE:
        return HIGH if high == limits[1] or low >= high else RISING
    if value < low - _TOLERANCE:
        return LOW if low == limits[0] or low >= high else FALLING
    if bound == FREE or low >= high:
        return bound
    on_top = bound in (HIGH, RISING)
    against = multiplier > _TOLERANCE if on_top else multiplier < -_TOLERANCE
    return FREE if against else bound
