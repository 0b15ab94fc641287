"""Solve many separate chains at once, where no bound is in the way.

A chain without slopes of downwash is the same at every stage, and its weight beyond the horizon is the one
that goes on for ever, so the Riccati matrix P is the same at every stage too. What is left of the recursion
is one vector a stage, back and forth (q2q_control.mpc.solver.riccati has the general form):

    V_k(x) = x' P x + 2 p_k' x;   Quu = R + S + B' P B;   Qux = B' P A - S e_a
    o_k = -(B' (P c_k + p_{k+1}) - R u*_k) / Quu
    p_k = A' (P c_k + p_{k+1}) - Q x*_k + Qux' o_k
    u_k = -Qux / Quu x_k + o_k

with u* = r''_ref - w and x* = (r_ref, r'_ref, u*). The answer is the optimum if no input crosses its bounds;
chains that do are told, and solved one by one.
"""

import numpy as np
from numpy.typing import NDArray

from q2q_control.mpc.chain import Chain
from q2q_control.mpc.problem.horizon import Horizon
from q2q_model.compiled import compiled
from q2q_model.signals.values import Array

Rows = NDArray[np.intp]
_B, _FEEDBACK, _QUX, _PUSH_AHEAD, _WEIGHT, _PUSH, _SCALARS = 0, 1, 2, 3, 4, 5, 6


def sweep_gains(model: Chain) -> Array:
    """Return what the sweep reads of a chain, (13, 3): vectors, scalars Quu and R, then A and P."""
    a, b, p = model.transition, model.input_gain, model.terminal
    effort, jerk = model.input_weight
    quu = effort + jerk + b @ p @ b
    qux = b @ p @ a - jerk * np.array([0.0, 0.0, 1.0])
    vectors = [b, qux / quu, qux, p @ model.push_gain, model.state_weight, model.push_gain]
    return np.concatenate([np.stack(vectors), [[quu, effort, 0.0]], a, p])


@compiled
def sweep(
    horizon: Horizon, chains: tuple[Rows, Rows], gains: Array, answer: tuple[Array, Array]
) -> NDArray[np.bool_]:
    """Fill `answer` (positions (n, N + 1, 3), inputs (n, N, 3)) of the chains (vehicles (C,), axes (C,)).

    Returns which chains keep their bounds, (C,). `gains` are those of `sweep_gains`, the same for all chains.
    """
    vehicles, axes = chains
    pos, inputs = answer
    inside = np.ones(vehicles.size, np.bool_)
    for c in range(vehicles.size):
        _offsets(horizon, vehicles[c], axes[c], (gains, inputs))
        inside[c] = _rolled_out(horizon, vehicles[c], axes[c], (gains, pos, inputs))
    return inside


@compiled(error_model="numpy")
def _offsets(horizon: Horizon, v: int, axis: int, arrays: tuple[Array, Array]) -> None:
    """Fill inputs[v, :, axis] with o_k, last to first."""
    gains, inputs = arrays
    reference, push = horizon.reference, horizon.push
    stages = push.shape[1]
    b, ahead_push, qux, weight = gains[_B], gains[_PUSH_AHEAD], gains[_QUX], gains[_WEIGHT]
    quu, effort = gains[_SCALARS, 0], gains[_SCALARS, 1]
    a, p = gains[7:10], gains[10:13]
    slope, ahead = np.empty(3), np.empty(3)
    end = reference[v, stages, 6 + axis] - push[v, stages - 1, axis]
    for i in range(3):
        slope[i] = -p[i, 0] * reference[v, stages, axis] - p[i, 1] * reference[v, stages, 3 + axis]
        slope[i] -= p[i, 2] * end
    for k in range(stages - 1, -1, -1):
        w = push[v, k, axis]
        wanted = reference[v, k, 6 + axis] - w
        for i in range(3):
            ahead[i] = slope[i] + w * ahead_push[i]
        lean = b[0] * ahead[0] + b[1] * ahead[1] + b[2] * ahead[2]
        offset = -(lean - effort * wanted) / quu
        inputs[v, k, axis] = offset
        for i in range(3):
            slope[i] = a[0, i] * ahead[0] + a[1, i] * ahead[1] + a[2, i] * ahead[2] + qux[i] * offset
        slope[0] -= weight[0] * reference[v, k, axis]
        slope[1] -= weight[1] * reference[v, k, 3 + axis]
        slope[2] -= weight[2] * wanted


@compiled(error_model="numpy")
def _rolled_out(horizon: Horizon, v: int, axis: int, arrays: tuple[Array, Array, Array]) -> bool:
    """Fill positions and inputs from the first stage on; return whether all bounds hold."""
    gains, pos, inputs = arrays
    b, feedback, push_gain, a = gains[_B], gains[_FEEDBACK], gains[_PUSH], gains[7:10]
    low, high, step = horizon.low[v, axis], horizon.high[v, axis], horizon.step[axis]
    p, s, acc = horizon.start[v, axis, 0], horizon.start[v, axis, 1], horizon.start[v, axis, 2]
    inside = True
    pos[v, 0, axis] = p
    for k in range(horizon.push.shape[1]):
        w = horizon.push[v, k, axis]
        u = inputs[v, k, axis] - feedback[0] * p - feedback[1] * s - feedback[2] * acc
        inputs[v, k, axis] = u
        inside = inside and max(low, acc - step) <= u <= min(high, acc + step)
        p += a[0, 1] * s + a[0, 2] * acc + b[0] * u + push_gain[0] * w
        s += a[1, 2] * acc + b[1] * u + push_gain[1] * w
        acc = a[2, 2] * acc + b[2] * u
        pos[v, k + 1, axis] = p
    return inside


@compiled
def sweep_free(
    horizon: Horizon, free: NDArray[np.bool_], gains: tuple[Array, Array], answer: tuple[Array, Array]
) -> NDArray[np.bool_]:
    """Fill `answer` of the chains that are `free` (n, 3); return which of them cross a bound, (n, 3).

    `gains` are those of x and y, then of z.
    """
    pos, inputs = answer
    crossing = np.zeros(free.shape, np.bool_)
    for v in range(free.shape[0]):
        for axis in range(3):
            if free[v, axis]:
                own = gains[0] if axis < 2 else gains[1]
                _offsets(horizon, v, axis, (own, inputs))
                crossing[v, axis] = not _rolled_out(horizon, v, axis, (own, pos, inputs))
    return crossing
