"""Judge on which bound each input of an LqProblem lies, after a solve with a guess of it.

An input that crosses a bound is put on it; one on a bound whose multiplier has the wrong sign, so that the
cost would fall if it left, is freed. Modes of inputs: inside, on high, on low, rising or falling as quickly
as the rate allows (u = a + step, u = a - step).
"""

import numpy as np
from numpy.typing import NDArray

from q2q_control.mpc.problem.lq_problem import LqProblem
from q2q_model.compiled import FAST, compiled
from q2q_model.signals.values import Array

FREE, HIGH, LOW, RISING, FALLING = 0, 1, 2, 3, 4
"""Where an input lies: inside, on high, on low, on a + step, on a - step."""

_TOLERANCE = 1e-9
"""How far beyond a bound [m/s^2], or of the wrong sign, counts."""


@compiled(**FAST)
def bounds_of(problem: LqProblem, k: int, c: int, acc: float) -> tuple[float, float]:
    """Return the range of an input whose acceleration is `acc`; low..high wins over the rate."""
    low, high = problem.low[k, c], problem.high[k, c]
    return min(max(low, acc - problem.step[c]), high), max(min(high, acc + problem.step[c]), low)


@compiled(**FAST)
def mend(
    problem: LqProblem,
    pattern: NDArray[np.int8],
    path: tuple[Array, Array],
    quadratics: tuple[Array, Array, Array],
    every: bool,
) -> int:
    """Put inputs on the bounds they cross, free those that want back; return how many ought to change.

    Where not `every`, only the last of them is changed.
    """
    states, inputs = path
    quu, qux, qu = quadratics
    stages, n = pattern.shape
    wrong, last_k, last_c, last_mode = 0, 0, 0, FREE
    for k in range(stages):
        for c in range(n):
            multiplier = 0.0
            if pattern[k, c] != FREE:
                multiplier = qu[k, c]
                for d in range(n):
                    multiplier += quu[k, c, d] * inputs[k, d]
                for i in range(3 * n):
                    multiplier += qux[k, c, i] * states[k, i]
            range_now = bounds_of(problem, k, c, states[k, 3 * c + 2])
            limits = (problem.low[k, c], problem.high[k, c])
            mode = _judged(pattern[k, c], inputs[k, c], multiplier, range_now, limits)
            if mode != pattern[k, c]:
                wrong, last_k, last_c, last_mode = wrong + 1, k, c, mode
                if every:
                    pattern[k, c] = mode
    if wrong > 0:
        pattern[last_k, last_c] = last_mode
    return wrong


@compiled(**FAST)
def _judged(
    mode: int, value: float, multiplier: float, range_now: tuple[float, float], limits: tuple[float, float]
) -> int:
    """Return where an input should lie; `range_now` are its bounds with the rate's, `limits` without."""
    low, high = range_now
    if value > high + _TOLERANCE:
        return HIGH if high == limits[1] or low >= high else RISING
    if value < low - _TOLERANCE:
        return LOW if low == limits[0] or low >= high else FALLING
    if mode == FREE or low >= high:
        return mode
    on_top = mode in (HIGH, RISING)
    against = multiplier > _TOLERANCE if on_top else multiplier < -_TOLERANCE
    return FREE if against else mode
