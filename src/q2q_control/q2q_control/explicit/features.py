"""Say what the explicit law looks at: a pair's states, what will push both, and what the bound takes away.

Heights are errors from the references, so all that is left of a reference is a push:

    e'' = a + p,   p = eta + d - r''_ref           eta along the paths as they are off their references now

Where no bound is met on the horizon, the optimum is the linear law of each chain: the central region of an
explicit MPC (Bemporad, Morari, Dua, Pistikopoulos, Automatica 38, 2002). Rolled out, it says where a bound
will be met:

    u_k                             unbounded optimum of each chain (q2q_control.mpc.solver.chain_sweep)
    c_k  = max(u_k - high, 0)       what the bound takes away
    gate = C / (C + SOFT),   C = max of c_k over the horizon and both vehicles
    x    = (e, e', a, mean p, mean c of the first, the same of the second, mean G of both), means over windows

One vehicle is the first, its neighbour the second; each of a pair looks with itself as the first. The
neighbour matters because it may make room: G says how much that brings.

| symbol | name | meaning [unit] |
|---|---|---|
| e e' a | states | height error [m], climb error [m/s], acceleration by thrust [m/s^2] |
| p | push | downwash, disturbance and minus the reference's acceleration, a stage each [m/s^2] |
| G | slope | what downwash changes by if its source is higher above [1/s^2] |
| o | offsets | what a chain's unbounded optimum does about the pushes alone [m/s^2] |
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from q2q_model.compiled import FAST, compiled
from q2q_model.signals.values import Array

STAGES = 40
"""Of the horizon."""
EDGES = (0, 1, 2, 4, 7, 10, 14, 18, 23, 28, 34, STAGES)
"""Windows of pushes, in stages: narrow where the law must act."""
SLOPE_EDGES = (0, 4, 14, STAGES)
"""Windows of slopes."""
WINDOWS, SLOPES = len(EDGES) - 1, len(SLOPE_EDGES) - 1
OWN = 3 + 2 * WINDOWS
"""Numbers of one vehicle."""
WIDTH = 2 * (OWN + SLOPES)
"""Numbers the law looks at."""
SOFT = 0.05
"""What a bound takes away where half of the network's answer counts [m/s^2]: a sixth of the paper's room."""
_B, _FEEDBACK, _QUX, _PUSH_AHEAD, _PUSH, _SCALARS, _A, _P = 0, 1, 2, 3, 5, 6, 7, 10


class PairHorizon(NamedTuple):
    """Predicted horizon of pairs, the first vehicle first."""

    states: Array
    """e, e', a, (..., 2, 3)."""
    push: Array
    """(..., 2, STAGES) [m/s^2]."""
    slope: Array
    """(..., 2, STAGES) [1/s^2]."""

    def swapped(self) -> "PairHorizon":
        """Return the same with the second vehicle first."""
        return PairHorizon(self.states[..., ::-1, :], self.push[..., ::-1, :], self.slope[..., ::-1, :])


@dataclass(frozen=True, slots=True)
class Features:
    """Features that the law sees of pairs."""

    x: Array
    """(..., WIDTH)"""
    gate: Array
    """0 where no bound is met, (...,)."""
    base: Array
    """The first vehicle's unbounded optimum now [m/s^2], (...,)."""


def look(pair: PairHorizon, gains: Array, high: float) -> Features:
    """Return what the law sees: the plain form; `gains` are those of `sweep_gains`."""
    wanted = _unbounded(pair.states, pair.push, gains)
    cut = np.maximum(wanted - high, 0.0)
    most = cut.max(axis=(-1, -2))
    own = np.concatenate([pair.states, _means(pair.push, EDGES), _means(cut, EDGES)], axis=-1)
    slopes = _means(pair.slope, SLOPE_EDGES)
    parts = [own[..., 0, :], own[..., 1, :], slopes[..., 0, :], slopes[..., 1, :]]
    return Features(np.concatenate(parts, axis=-1), most / (most + SOFT), wanted[..., 0, 0])


def _unbounded(states: Array, push: Array, gains: Array) -> Array:
    """Return the unbounded optimum of each chain, rolled out, (..., N)."""
    a, p = gains[_A : _A + 3], gains[_P : _P + 3]
    quu, effort = gains[_SCALARS, :2]
    stages = push.shape[-1]
    offset = np.empty(push.shape)
    slope = push[..., -1, None] * p[:, 2]
    for k in range(stages - 1, -1, -1):
        ahead = slope + push[..., k, None] * gains[_PUSH_AHEAD]
        offset[..., k] = -(ahead @ gains[_B] + effort * push[..., k]) / quu
        slope = ahead @ a + offset[..., k, None] * gains[_QUX]
    wanted, state = np.empty(push.shape), states
    for k in range(stages):
        wanted[..., k] = offset[..., k] - state @ gains[_FEEDBACK]
        state = state @ a.T + wanted[..., k, None] * gains[_B] + push[..., k, None] * gains[_PUSH]
    return wanted


def _means(values: Array, edges: tuple[int, ...]) -> Array:
    return np.stack([values[..., low:high].mean(axis=-1) for low, high in pairwise(edges)], axis=-1)


@compiled(**FAST)
def look_one(
    pair: tuple[Array, Array, Array], gains: Array, high: float, wanted: Array, x: Array
) -> tuple[float, float]:
    """Write x of one pair, return base and gate: (PairHorizon's parts, gains, high, wanted (2, N), x)."""
    states, push, slope = pair
    _roll_out(states, push, gains, wanted)
    most = 0.0
    for v in range(2):
        for i in range(3):
            x[v * OWN + i] = states[v, i]
        for w in range(WINDOWS):
            total, taken = 0.0, 0.0
            for k in range(EDGES[w], EDGES[w + 1]):
                cut = max(wanted[v, k] - high, 0.0)
                total, taken, most = total + push[v, k], taken + cut, max(most, cut)
            width = EDGES[w + 1] - EDGES[w]
            x[v * OWN + 3 + w] = total / width
            x[v * OWN + 3 + WINDOWS + w] = taken / width
        for w in range(SLOPES):
            total = 0.0
            for k in range(SLOPE_EDGES[w], SLOPE_EDGES[w + 1]):
                total += slope[v, k]
            x[2 * OWN + v * SLOPES + w] = total / (SLOPE_EDGES[w + 1] - SLOPE_EDGES[w])
    return wanted[0, 0], most / (most + SOFT)


@compiled(**FAST)
def _roll_out(states: Array, push: Array, gains: Array, wanted: Array) -> None:
    """Write both chains' unbounded optima (2, N), side by side: one waits for itself, two do not."""
    each, effort, end = 1.0 / gains[_SCALARS, 0], gains[_SCALARS, 1], push.shape[1] - 1
    b0, b1, b2 = gains[_B, 0], gains[_B, 1], gains[_B, 2]
    q0, q1, q2 = gains[_QUX, 0], gains[_QUX, 1], gains[_QUX, 2]
    h0, h1, h2 = gains[_PUSH_AHEAD, 0], gains[_PUSH_AHEAD, 1], gains[_PUSH_AHEAD, 2]
    a01, a02, a12, a22 = gains[_A, 1], gains[_A, 2], gains[_A + 1, 2], gains[_A + 2, 2]
    p, r, u, w = push[0], push[1], wanted[0], wanted[1]
    x0, x1, x2 = gains[_P, 2] * p[end], gains[_P + 1, 2] * p[end], gains[_P + 2, 2] * p[end]
    y0, y1, y2 = gains[_P, 2] * r[end], gains[_P + 1, 2] * r[end], gains[_P + 2, 2] * r[end]
    for k in range(end, -1, -1):
        x0, x1, x2 = x0 + p[k] * h0, x1 + p[k] * h1, x2 + p[k] * h2
        y0, y1, y2 = y0 + r[k] * h0, y1 + r[k] * h1, y2 + r[k] * h2
        u[k] = -(b0 * x0 + b1 * x1 + b2 * x2 + effort * p[k]) * each
        w[k] = -(b0 * y0 + b1 * y1 + b2 * y2 + effort * r[k]) * each
        x2, x1, x0 = a02 * x0 + a12 * x1 + a22 * x2 + u[k] * q2, a01 * x0 + x1 + u[k] * q1, x0 + u[k] * q0
        y2, y1, y0 = a02 * y0 + a12 * y1 + a22 * y2 + w[k] * q2, a01 * y0 + y1 + w[k] * q1, y0 + w[k] * q0
    k0, k1, k2 = gains[_FEEDBACK, 0], gains[_FEEDBACK, 1], gains[_FEEDBACK, 2]
    d0, d1 = gains[_PUSH, 0], gains[_PUSH, 1]
    x0, x1, x2 = states[0, 0], states[0, 1], states[0, 2]
    y0, y1, y2 = states[1, 0], states[1, 1], states[1, 2]
    for k in range(end + 1):
        f, g = u[k] - k0 * x0 - k1 * x1 - k2 * x2, w[k] - k0 * y0 - k1 * y1 - k2 * y2
        u[k], w[k] = f, g
        x0, y0 = x0 + a01 * x1 + a02 * x2 + b0 * f + d0 * p[k], y0 + a01 * y1 + a02 * y2 + b0 * g + d0 * r[k]
        x1, y1 = x1 + a12 * x2 + b1 * f + d1 * p[k], y1 + a12 * y2 + b1 * g + d1 * r[k]
        x2, y2 = a22 * x2 + b2 * f, a22 * y2 + b2 * g
