"""Solution of many separate axes at once where no bound is active.

An axis without gradients of downwash is the same at every stage, and its terminal weight is that of the
infinite horizon, so the Riccati matrix P is constant too. What is left of the recursion is one vector per
stage, backward and forward (q2q_control.mpc.solver.riccati has the general form):

    V_k(x) = x' P x + 2 p_k' x;   Quu = R + S + B' P B;   Qux = B' P A - S e_a
    o_k = -(B' (P c_k + p_{k+1}) - R u*_k) / Quu
    p_k = A' (P c_k + p_{k+1}) - Q x*_k + Qux' o_k
    u_k = -Qux / Quu x_k + o_k

with u* = r''_ref - w and x* = (r_ref, r'_ref, u*). The solution is optimal if no input crosses its bounds;
axes that cross one are returned, and solved one by one.
"""

from typing import NamedTuple

import numpy as np

from q2q_control.mpc.problem.axis_model import AxisModel
from q2q_control.mpc.problem.horizon import Horizon, HorizonSolution
from q2q_model.compiled import compiled
from q2q_model.signals.values import Array, Mask


class AxisGains(NamedTuple):
    """Constants of the sweep of one axis."""

    input: Array
    """B, (3,)."""
    feedback: Array
    """Qux / Quu, (3,)."""
    qux: Array
    """(3,)"""
    push_cost: Array
    """P times the push gain, (3,)."""
    weight: Array
    """Q, (3,)."""
    push: Array
    """Push gain, (3,)."""
    quu: float
    effort: float
    """R."""
    transition: Array
    """A, (3, 3)."""
    terminal: Array
    """P, (3, 3)."""


def sweep_gains(model: AxisModel) -> AxisGains:
    """Return the constants of an axis."""
    a, b, p = model.transition, model.input_gain, model.cost.terminal
    effort, jerk = (float(weight) for weight in model.cost.input_weight)
    quu = effort + jerk + float(b @ p @ b)
    qux = b @ p @ a - jerk * np.array([0.0, 0.0, 1.0])
    return AxisGains(
        input=b,
        feedback=qux / quu,
        qux=qux,
        push_cost=p @ model.push_gain,
        weight=model.cost.state_weight,
        push=model.push_gain,
        quu=quu,
        effort=effort,
        transition=a,
        terminal=np.ascontiguousarray(p),
    )


def gains_table(gains: AxisGains) -> Array:
    """Return the gains of an axis as a table, (13, 3)."""
    vectors = np.stack([gains.input, gains.feedback, gains.qux, gains.push_cost, gains.weight, gains.push])
    return np.concatenate([vectors, [[gains.quu, gains.effort, 0.0]], gains.transition, gains.terminal])


@compiled
def gains_of_table(table: Array) -> AxisGains:
    """Return gains from their table: numba looks at every field of a tuple in each call from Python."""
    b, feedback, qux, push_cost, weight, push = table[0], table[1], table[2], table[3], table[4], table[5]
    quu, effort = table[6, 0], table[6, 1]
    return AxisGains(b, feedback, qux, push_cost, weight, push, quu, effort, table[7:10], table[10:13])


@compiled
def sweep_axes(
    horizon: Horizon, free: Mask, gains: tuple[AxisGains, AxisGains], solution: HorizonSolution
) -> Mask:
    """Write positions and inputs of the axes that are `free` (n, 3); return which cross a bound, (n, 3).

    `gains` are those of x and y, then of z.
    """
    crossing = np.zeros(free.shape, np.bool_)
    for v in range(free.shape[0]):
        for axis in range(3):
            if free[v, axis]:
                own = gains[0] if axis < 2 else gains[1]
                _write_offsets(horizon, v, axis, own, solution.inputs)
                crossing[v, axis] = not _roll_out(horizon, v, axis, own, solution)
    return crossing


@compiled(error_model="numpy")
def _write_offsets(horizon: Horizon, v: int, axis: int, gains: AxisGains, inputs: Array) -> None:
    """Write o_k into inputs[v, :, axis], last to first."""
    reference, push = horizon.reference, horizon.push
    stages = push.shape[1]
    a, b, p, qux = gains.transition, gains.input, gains.terminal, gains.qux
    slope, ahead = np.empty(3), np.empty(3)
    end = reference[v, stages, 6 + axis] - push[v, stages - 1, axis]
    for i in range(3):
        slope[i] = -p[i, 0] * reference[v, stages, axis] - p[i, 1] * reference[v, stages, 3 + axis]
        slope[i] -= p[i, 2] * end
    for k in range(stages - 1, -1, -1):
        w = push[v, k, axis]
        target = reference[v, k, 6 + axis] - w
        for i in range(3):
            ahead[i] = slope[i] + w * gains.push_cost[i]
        lean = b[0] * ahead[0] + b[1] * ahead[1] + b[2] * ahead[2]
        offset = -(lean - gains.effort * target) / gains.quu
        inputs[v, k, axis] = offset
        for i in range(3):
            slope[i] = a[0, i] * ahead[0] + a[1, i] * ahead[1] + a[2, i] * ahead[2] + qux[i] * offset
        slope[0] -= gains.weight[0] * reference[v, k, axis]
        slope[1] -= gains.weight[1] * reference[v, k, 3 + axis]
        slope[2] -= gains.weight[2] * target


@compiled(error_model="numpy")
def _roll_out(horizon: Horizon, v: int, axis: int, gains: AxisGains, solution: HorizonSolution) -> bool:
    """Write positions and inputs from the first stage on; return whether all bounds hold."""
    a, b, feedback, push = gains.transition, gains.input, gains.feedback, gains.push
    low, slew_max = horizon.low[v, axis], horizon.slew_max[axis]
    pos, vel, acc = horizon.start[v, axis, 0], horizon.start[v, axis, 1], horizon.start[v, axis, 2]
    inside = True
    solution.pos[v, 0, axis] = pos
    for k in range(horizon.push.shape[1]):
        w = horizon.push[v, k, axis]
        u = solution.inputs[v, k, axis] - feedback[0] * pos - feedback[1] * vel - feedback[2] * acc
        solution.inputs[v, k, axis] = u
        high = horizon.high[v, k, axis]
        inside = inside and max(low, acc - slew_max) <= u <= min(high, acc + slew_max)
        pos += a[0, 1] * vel + a[0, 2] * acc + b[0] * u + push[0] * w
        vel += a[1, 2] * acc + b[1] * u + push[1] * w
        acc = a[2, 2] * acc + b[2] * u
        solution.pos[v, k + 1, axis] = pos
    return inside
