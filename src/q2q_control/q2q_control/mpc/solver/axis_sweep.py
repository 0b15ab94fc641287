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

from q2q_control.mpc.problem.axis_model import AxisModel, AxisModels
from q2q_control.mpc.problem.horizon import Horizon, HorizonSolution
from q2q_model.compiled import compiled
from q2q_model.signals.values import Array, Mask, Rows


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


class SweepGains(NamedTuple):
    """Constants of the sweep of x, y and z, each as that of AxisGains."""

    input: Array
    """(3, 3)"""
    feedback: Array
    """(3, 3)"""
    qux: Array
    """(3, 3)"""
    push_cost: Array
    """(3, 3)"""
    weight: Array
    """(3, 3)"""
    push: Array
    """(3, 3)"""
    scalars: Array
    """Quu and R, (3, 3)."""
    transition: Array
    """(3, 3, 3)"""
    terminal: Array
    """(3, 3, 3)"""


def sweep_tables(models: AxisModels) -> Array:
    """Return the tables of the gains of x, y, z, (3, 13, 3)."""
    return np.stack([gains_table(sweep_gains(model)) for model in models])


def gains_of_table(table: Array) -> AxisGains:
    """Return the gains of an axis from their table, (13, 3)."""
    b, feedback, qux, push_cost, weight, push = table[0], table[1], table[2], table[3], table[4], table[5]
    quu, effort = float(table[6, 0]), float(table[6, 1])
    return AxisGains(b, feedback, qux, push_cost, weight, push, quu, effort, table[7:10], table[10:13])


@compiled
def sweep_axes(horizon: Horizon, free: Mask, tables: Array, solution: HorizonSolution) -> Mask:
    """Write positions and inputs of the axes that are `free` (n, 3); return which cross a bound, (n, 3).

    `tables` (3, 13, 3) are those of `sweep_tables`. An axis waits in each stage for the result of the one
    before, so the axes of a vehicle are swept side by side.
    """
    gains, crossing = _gains_of_tables(tables), np.zeros(free.shape, np.bool_)
    for v in range(free.shape[0]):
        axes = np.flatnonzero(free[v])
        _write_offsets(horizon, v, axes, gains, solution.inputs)
        _roll_out(horizon, (v, axes), gains, solution, crossing[v])
    return crossing


@compiled
def _gains_of_tables(tables: Array) -> SweepGains:
    """Return the gains of x, y, z from their tables (3, 13, 3)."""
    return SweepGains(
        tables[:, 0],
        tables[:, 1],
        tables[:, 2],
        tables[:, 3],
        tables[:, 4],
        tables[:, 5],
        tables[:, 6],
        tables[:, 7:10],
        tables[:, 10:13],
    )


@compiled(error_model="numpy")
def _write_offsets(horizon: Horizon, v: int, axes: Rows, gains: SweepGains, inputs: Array) -> None:
    """Write o_k into inputs[v, :, axis] of `axes`, last to first."""
    reference, push = horizon.reference, horizon.push
    stages = push.shape[1]
    a, b, p, qux = gains.transition, gains.input, gains.terminal, gains.qux
    slope, ahead = np.empty((3, 3)), np.empty((3, 3))
    for c in axes:
        end = reference[v, stages, 6 + c] - push[v, stages - 1, c]
        for i in range(3):
            slope[c, i] = -p[c, i, 0] * reference[v, stages, c] - p[c, i, 1] * reference[v, stages, 3 + c]
            slope[c, i] -= p[c, i, 2] * end
    for k in range(stages - 1, -1, -1):
        for c in axes:
            w = push[v, k, c]
            target = reference[v, k, 6 + c] - w
            for i in range(3):
                ahead[c, i] = slope[c, i] + w * gains.push_cost[c, i]
            lean = b[c, 0] * ahead[c, 0] + b[c, 1] * ahead[c, 1] + b[c, 2] * ahead[c, 2]
            offset = -(lean - gains.scalars[c, 1] * target) / gains.scalars[c, 0]
            inputs[v, k, c] = offset
            for i in range(3):
                slope[c, i] = a[c, 0, i] * ahead[c, 0] + a[c, 1, i] * ahead[c, 1] + a[c, 2, i] * ahead[c, 2]
                slope[c, i] += qux[c, i] * offset
            slope[c, 0] -= gains.weight[c, 0] * reference[v, k, c]
            slope[c, 1] -= gains.weight[c, 1] * reference[v, k, 3 + c]
            slope[c, 2] -= gains.weight[c, 2] * target


@compiled(error_model="numpy")
def _roll_out(
    horizon: Horizon, of: tuple[int, Rows], gains: SweepGains, solution: HorizonSolution, crossing: Mask
) -> None:
    """Write positions and inputs from the first stage on, and which axes cross a bound, (3,)."""
    v, axes = of
    a, b, feedback, push = gains.transition, gains.input, gains.feedback, gains.push
    low, slew_max, state = horizon.low[v], horizon.slew_max, np.empty((3, 3))
    for c in axes:
        state[c] = horizon.start[v, c]
        solution.pos[v, 0, c] = state[c, 0]
    for k in range(horizon.push.shape[1]):
        for c in axes:
            pos, vel, acc = state[c, 0], state[c, 1], state[c, 2]
            w = horizon.push[v, k, c]
            u = solution.inputs[v, k, c] - feedback[c, 0] * pos - feedback[c, 1] * vel - feedback[c, 2] * acc
            solution.inputs[v, k, c] = u
            high = horizon.high[v, k, c]
            if not max(low[c], acc - slew_max[c]) <= u <= min(high, acc + slew_max[c]):
                crossing[c] = True
            state[c, 0] += a[c, 0, 1] * vel + a[c, 0, 2] * acc + b[c, 0] * u + push[c, 0] * w
            state[c, 1] += a[c, 1, 2] * acc + b[c, 1] * u + push[c, 1] * w
            state[c, 2] = a[c, 2, 2] * acc + b[c, 2] * u
            solution.pos[v, k + 1, c] = state[c, 0]
