"""Active set of an LqProblem: the bound that each input lies on, updated after a solve with a guess of it.

An input that crosses a bound is put on it. An input on a bound is freed where its multiplier has the wrong
sign, so that leaving the bound lowers the cost. Modes of inputs: free, on high, on low, rising or falling as
fast as the rate allows (u = a + slew_max, u = a - slew_max).
"""

import numpy as np
from numpy.typing import NDArray

from q2q_control.mpc.problem.lq_problem import LqProblem
from q2q_control.mpc.solver.workspace import Workspace
from q2q_model.compiled import FAST, compiled

Modes = NDArray[np.int8]

FREE, HIGH, LOW, RISING, FALLING = 0, 1, 2, 3, 4
"""Mode of an input: free, on high, on low, on a + slew_max, on a - slew_max."""

_TOLERANCE = 1e-9
"""Violation of a bound [m/s^2], or multiplier of the wrong sign, below which nothing changes."""


@compiled(**FAST)
def input_range(problem: LqProblem, k: int, c: int, acc: float) -> tuple[float, float]:
    """Return the range of an input at acceleration `acc`; low and high take precedence over the rate."""
    low, high = problem.low[k, c], problem.high[k, c]
    return min(max(low, acc - problem.slew_max[c]), high), max(min(high, acc + problem.slew_max[c]), low)


@compiled(**FAST)
def update_active_set(problem: LqProblem, pattern: Modes, work: Workspace, every: bool) -> tuple[int, int]:
    """Return how many inputs have the wrong mode and the last stage of one; correct `pattern` (N, n).

    All of them are corrected where `every`, else the last one only.
    """
    stages, n = pattern.shape
    wrong, last_k, last_c, last_mode = 0, 0, 0, FREE
    for k in range(stages):
        for c in range(n):
            multiplier = 0.0
            if pattern[k, c] != FREE:
                multiplier = work.qu[k, c]
                for d in range(n):
                    multiplier += work.quu[k, c, d] * work.inputs[k, d]
                for i in range(3 * n):
                    multiplier += work.qux[k, c, i] * work.states[k, i]
            allowed = input_range(problem, k, c, work.states[k, 3 * c + 2])
            limits = (problem.low[k, c], problem.high[k, c])
            mode = _corrected(pattern[k, c], work.inputs[k, c], multiplier, allowed, limits)
            if mode != pattern[k, c]:
                wrong, last_k, last_c, last_mode = wrong + 1, k, c, mode
                if every:
                    pattern[k, c] = mode
    if wrong > 0:
        pattern[last_k, last_c] = last_mode
    return wrong, last_k


@compiled(**FAST)
def _corrected(
    mode: int, value: float, multiplier: float, allowed: tuple[float, float], limits: tuple[float, float]
) -> int:
    """Return the right mode of an input; `allowed` is its range with the rate's bounds, `limits` without."""
    low, high = allowed
    if value > high + _TOLERANCE:
        return HIGH if high == limits[1] or low >= high else RISING
    if value < low - _TOLERANCE:
        return LOW if low == limits[0] or low >= high else FALLING
    if mode == FREE or low >= high:
        return mode
    on_top = mode in (HIGH, RISING)
    against = multiplier > _TOLERANCE if on_top else multiplier < -_TOLERANCE
    return FREE if against else mode
