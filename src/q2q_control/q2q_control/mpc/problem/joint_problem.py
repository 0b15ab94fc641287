"""LqProblem of vehicles that are solved together: build only, no solving.

It holds the models of the group's axes, with the downwash in their transition and drift linearised along the
last prediction r~ (q2q_control.mpc.prediction.downwash_horizon):

    w_i,k = w~_i,k + sum_j G_ij,k ((r_j - r~_j) - (r_i - r~_i))

A source outside the group moves as predicted, so only r_i counts. What does not change from tick to tick is
built once for each shape of group; a compiled loop fills in the rest.
"""

from typing import NamedTuple

import numpy as np

from q2q_control.mpc.problem.axis_model import AxisModels
from q2q_control.mpc.problem.horizon import DownwashHorizon, Horizon
from q2q_control.mpc.problem.lq_problem import LqProblem
from q2q_model.compiled import compiled
from q2q_model.signals.values import Array, Rows


class GroupShape(NamedTuple):
    """Structure shared by problems of equal vehicle count and axes."""

    axes: Rows
    """Of each vehicle, (a,), of 0 1 2: x y z."""
    transition: Array
    """(n, 3, 3); n = vehicles times a. This and the following are fields of LqProblem."""
    push_gain: Array
    """(n, 3)."""
    input_gain: Array
    """(n, 3)."""
    state_weight: Array
    """(n, 3)."""
    terminal: Array
    """(n, 3, 3)."""
    input_weight: Array
    """(n, 2)."""


PlainShape = tuple[Rows, Array, Array, Array, Array, Array, Array]
"""Fields of a GroupShape, which numba takes from Python in less than half the time."""


def group_shape(
    size: int, axes: tuple[int, ...], models: AxisModels, terminal_weight: float = 1.0
) -> GroupShape:
    """Return the shape of groups of `size` vehicles; `models` are those of x, y, z.

    Their terminal weights count `terminal_weight` times.
    """
    own = [models[axis] for axis in axes] * size
    return GroupShape(
        axes=np.array(axes, np.intp),
        transition=np.stack([model.transition for model in own]),
        push_gain=np.stack([model.push_gain for model in own]),
        input_gain=np.stack([model.input_gain for model in own]),
        state_weight=np.stack([model.cost.state_weight for model in own]),
        terminal=terminal_weight * np.stack([model.cost.terminal for model in own]),
        input_weight=np.stack([model.cost.input_weight for model in own]),
    )


@compiled
def joint_problem(
    shape: GroupShape, vehicles: Rows, horizon: Horizon, downwash: DownwashHorizon
) -> LqProblem:
    """Return the problem of the group `vehicles` (g,), inputs vehicle by vehicle, axis by axis."""
    inputs, stages = vehicles.size * shape.axes.size, horizon.push.shape[1]
    problem = LqProblem(
        np.empty(3 * inputs),
        shape.transition,
        shape.push_gain,
        np.zeros((stages, inputs, inputs)),
        np.empty((stages, 3 * inputs)),
        shape.input_gain,
        shape.state_weight,
        shape.terminal,
        np.empty((stages + 1, 3 * inputs)),
        shape.input_weight,
        np.empty((stages, inputs)),
        np.empty((stages, inputs)),
        np.empty((stages, inputs)),
        np.empty(inputs),
    )
    _fill_targets(shape, vehicles, horizon, problem)
    _fill_bounds(shape, vehicles, horizon, problem)
    _fill_gradients(shape, vehicles, downwash, horizon.path, problem)
    return problem


@compiled
def _fill_bounds(shape: GroupShape, vehicles: Rows, horizon: Horizon, problem: LqProblem) -> None:
    """Write start, low, high and slew_max."""
    axes = shape.axes
    for g in range(vehicles.size):
        for a in range(axes.size):
            v, axis, c = vehicles[g], axes[a], g * axes.size + a
            problem.slew_max[c] = horizon.slew_max[axis]
            for row in range(3):
                problem.start[3 * c + row] = horizon.start[v, axis, row]
            for k in range(problem.low.shape[0]):
                problem.low[k, c], problem.high[k, c] = horizon.low[v, axis], horizon.high[v, k, axis]


@compiled
def _fill_targets(shape: GroupShape, vehicles: Rows, horizon: Horizon, problem: LqProblem) -> None:
    """Write targets and the drift by downwash along the last prediction."""
    axes, target = shape.axes, problem.target
    stages = horizon.push.shape[1]
    for g in range(vehicles.size):
        for a in range(axes.size):
            v, axis, c = vehicles[g], axes[a], g * axes.size + a
            for k in range(stages + 1):
                w = horizon.push[v, min(k, stages - 1), axis]
                acc = horizon.reference[v, k, 6 + axis] - w
                target[k, 3 * c] = horizon.reference[v, k, axis]
                target[k, 3 * c + 1] = horizon.reference[v, k, 3 + axis]
                target[k, 3 * c + 2] = acc
                if k < stages:
                    problem.input_target[k, c] = acc
                    for row in range(3):
                        problem.drift[k, 3 * c + row] = shape.push_gain[c, row] * w


@compiled
def _fill_gradients(
    shape: GroupShape, vehicles: Rows, downwash: DownwashHorizon, path: Array, problem: LqProblem
) -> None:
    """Add G of each pair to the gradients, and -G r~ to the drift."""
    axes, count = shape.axes, shape.axes.size
    place = np.full(path.shape[0], -1)
    for g in range(vehicles.size):
        place[vehicles[g]] = g
    for pair in range(downwash.i.size):
        i, j = downwash.i[pair], downwash.j[pair]
        if place[i] < 0:
            continue
        for a in range(count):
            feels = place[i] * count + a
            for b in range(count):
                for side in range(2):
                    vehicle, sign = (i, -1.0) if side == 0 else (j, 1.0)
                    if place[vehicle] < 0:
                        continue
                    moves = place[vehicle] * count + b
                    for k in range(problem.drift.shape[0]):
                        gradient = sign * downwash.gradient[pair, k, axes[a], axes[b]]
                        problem.gradient[k, feels, moves] += gradient
                        for row in range(2):
                            pushed = shape.push_gain[feels, row] * gradient
                            problem.drift[k, 3 * feels + row] -= pushed * path[vehicle, k, axes[b]]
