"""Features of the explicit law: a pair's states, the pushes on both, and the excess beyond the bound.

Heights are errors from the references, so a reference enters through its acceleration only:

    e'' = a + p,   p = eta + d - r''_ref           eta along paths parallel to the references

Where no bound is met on the horizon, the optimum is the linear law of each axis: the central region of an
explicit MPC (Bemporad, Morari, Dua, Pistikopoulos, Automatica 38, 2002). Its roll-out shows where a bound
will be met:

    u_k                             unbounded optimum of each axis (q2q_control.mpc.solver.axis_sweep)
    c_k  = max(u_k - high, 0)       excess beyond the bound
    gate = C / (C + SOFT),   C = max of c_k over the horizon and both vehicles
    x    = (e, e', a, mean p, mean c of the first, the same of the second, mean G of both), means over windows

Each vehicle of a pair evaluates the law with itself as the first and its neighbour as the second. The
neighbour matters because it may evade: G is the benefit of that.

| symbol | name | meaning [unit] |
|---|---|---|
| e e' a | states | height error [m], climb error [m/s], acceleration by thrust [m/s^2] |
| p | push | downwash, disturbance and minus the reference's acceleration of each stage [m/s^2] |
| G | gradient | change of downwash with the height of its source above [1/s^2] |
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from q2q_control.mpc.solver.axis_sweep import AxisGains
from q2q_model.compiled import FAST, compiled
from q2q_model.signals.values import Array

STAGES = 40
"""Of the horizon."""
EDGES = (0, 1, 2, 4, 7, 10, 14, 18, 23, 28, 34, STAGES)
"""Windows of pushes, in stages: narrow in the near future."""
GRADIENT_EDGES = (0, 4, 14, STAGES)
"""Windows of gradients."""
WINDOWS, GRADIENTS = len(EDGES) - 1, len(GRADIENT_EDGES) - 1
OWN = 3 + 2 * WINDOWS
"""Features of one vehicle."""
WIDTH = 2 * (OWN + GRADIENTS)
"""Features of a pair."""
SOFT = 0.05
"""Excess at which the gate is half open [m/s^2]: a sixth of the paper's thrust margin."""


class PairHorizon(NamedTuple):
    """Predicted horizon of pairs, the first vehicle first."""

    states: Array
    """e, e', a, (..., 2, 3)."""
    push: Array
    """(..., 2, STAGES) [m/s^2]."""
    gradient: Array
    """(..., 2, STAGES) [1/s^2]."""

    def swapped(self) -> "PairHorizon":
        """Return the same with the second vehicle first."""
        return PairHorizon(self.states[..., ::-1, :], self.push[..., ::-1, :], self.gradient[..., ::-1, :])


@dataclass(frozen=True, slots=True)
class Features:
    """Features of pairs."""

    x: Array
    """(..., WIDTH)"""
    gate: Array
    """0 where no bound is met, (...,)."""
    base: Array
    """The first vehicle's unbounded optimum now [m/s^2], (...,)."""


def features(pair: PairHorizon, gains: AxisGains, high: float) -> Features:
    """Return the features of pairs; `high` is the upper bound of the command [m/s^2]."""
    unbounded = _unbounded(pair.states, pair.push, gains)
    excess = np.maximum(unbounded - high, 0.0)
    most = excess.max(axis=(-1, -2))
    own = np.concatenate([pair.states, _means(pair.push, EDGES), _means(excess, EDGES)], axis=-1)
    gradients = _means(pair.gradient, GRADIENT_EDGES)
    parts = [own[..., 0, :], own[..., 1, :], gradients[..., 0, :], gradients[..., 1, :]]
    return Features(np.concatenate(parts, axis=-1), most / (most + SOFT), unbounded[..., 0, 0])


def _unbounded(states: Array, push: Array, gains: AxisGains) -> Array:
    """Return the unbounded optimum of each axis, rolled out, (..., N)."""
    stages = push.shape[-1]
    offset = np.empty(push.shape)
    slope = push[..., -1, None] * gains.terminal[:, 2]
    for k in range(stages - 1, -1, -1):
        ahead = slope + push[..., k, None] * gains.push_cost
        offset[..., k] = -(ahead @ gains.input + gains.effort * push[..., k]) / gains.quu
        slope = ahead @ gains.transition + offset[..., k, None] * gains.qux
    u, state = np.empty(push.shape), states
    for k in range(stages):
        u[..., k] = offset[..., k] - state @ gains.feedback
        state = state @ gains.transition.T + u[..., k, None] * gains.input + push[..., k, None] * gains.push
    return u


def _means(values: Array, edges: tuple[int, ...]) -> Array:
    return np.stack([values[..., low:high].mean(axis=-1) for low, high in pairwise(edges)], axis=-1)


@compiled(**FAST)
def write_features(
    pair: PairHorizon, gains: AxisGains, high: float, unbounded: Array, x: Array
) -> tuple[float, float]:
    """Write x (WIDTH,) and the unbounded optima (2, N) of one pair; return base [m/s^2] and gate [-].

    `high` is the upper bound of the command [m/s^2].
    """
    most = 0.0
    for v in range(2):
        _write_unbounded(pair.states[v], pair.push[v], gains, unbounded[v])
        for i in range(3):
            x[v * OWN + i] = pair.states[v, i]
        for w in range(WINDOWS):
            total, taken = 0.0, 0.0
            for k in range(EDGES[w], EDGES[w + 1]):
                excess = max(unbounded[v, k] - high, 0.0)
                total, taken, most = total + pair.push[v, k], taken + excess, max(most, excess)
            width = EDGES[w + 1] - EDGES[w]
            x[v * OWN + 3 + w] = total / width
            x[v * OWN + 3 + WINDOWS + w] = taken / width
        for w in range(GRADIENTS):
            total = 0.0
            for k in range(GRADIENT_EDGES[w], GRADIENT_EDGES[w + 1]):
                total += pair.gradient[v, k]
            x[2 * OWN + v * GRADIENTS + w] = total / (GRADIENT_EDGES[w + 1] - GRADIENT_EDGES[w])
    return unbounded[0, 0], most / (most + SOFT)


@compiled(**FAST)
def _write_unbounded(state: Array, push: Array, gains: AxisGains, u: Array) -> None:
    """Write the unbounded optimum of one axis (N,), of state (3,) and push (N,)."""
    a, b, qux, feedback = gains.transition, gains.input, gains.qux, gains.feedback
    cost, terminal, drift = gains.push_cost, gains.terminal, gains.push
    last, per_quu = push.size - 1, 1.0 / gains.quu
    l0, l1, l2 = terminal[0, 2] * push[last], terminal[1, 2] * push[last], terminal[2, 2] * push[last]
    for k in range(last, -1, -1):
        l0, l1, l2 = l0 + push[k] * cost[0], l1 + push[k] * cost[1], l2 + push[k] * cost[2]
        u[k] = -(b[0] * l0 + b[1] * l1 + b[2] * l2 + gains.effort * push[k]) * per_quu
        l2 = a[0, 2] * l0 + a[1, 2] * l1 + a[2, 2] * l2 + u[k] * qux[2]
        l1 = a[0, 1] * l0 + l1 + u[k] * qux[1]
        l0 = l0 + u[k] * qux[0]
    e, v, acc = state[0], state[1], state[2]
    for k in range(last + 1):
        u[k] = u[k] - feedback[0] * e - feedback[1] * v - feedback[2] * acc
        e = e + a[0, 1] * v + a[0, 2] * acc + b[0] * u[k] + drift[0] * push[k]
        v = v + a[1, 2] * acc + b[1] * u[k] + drift[1] * push[k]
        acc = a[2, 2] * acc + b[2] * u[k]
