"""Exact step h of Ornstein-Uhlenbeck processes of correlation time T and unit variance.

    n(t + h) = n(t) e^(-h/T) + sqrt(1 - e^(-2 h/T)) w,    w ~ N(0, 1)

A process that begins with n ~ N(0, 1) is stationary from the first step on, whatever h. Source: Gillespie,
Exact numerical simulation of the Ornstein-Uhlenbeck process, Phys. Rev. E 54, 1996.
"""

import math
from typing import NamedTuple

from q2q_model.compiled import BORROWING, compiled
from q2q_model.signals.values import Array


class ExactStep(NamedTuple):
    """Weights of a step [-]."""

    keep: float
    """Of the value before."""
    fresh: float
    """Of white noise."""


def exact_step(step: float, time: float, std: float = 1.0) -> ExactStep:
    """Return the weights for a step [s], a correlation time [s] and a standard deviation."""
    return ExactStep(math.exp(-step / time), std * math.sqrt(-math.expm1(-2.0 * step / time)))


@compiled(**BORROWING)
def advance_processes(values: Array, white: Array, weights: ExactStep) -> None:
    """Advance processes (n,) in place by one step, by white noise (n,)."""
    for i in range(values.size):
        values[i] = weights.keep * values[i] + weights.fresh * white[i]
