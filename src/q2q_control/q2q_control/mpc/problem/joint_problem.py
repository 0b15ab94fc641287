"""Build the problem of vehicles that are solved together: build only, no solving.

The chains of the group's axes, and in their transition and drift the downwash linearised along the last
prediction r~ (q2q_control.mpc.prediction.downwash_horizon):

    w_i,k = w~_i,k + sum_j G_ij,k ((r_j - r~_j) - (r_i - r~_i))

A source outside the group moves as predicted: only r_i counts then. What is the same every tick is built
once a shape of group; a compiled loop fills in the rest.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from q2q_control.mpc.chain import Chain
from q2q_control.mpc.prediction.downwash_horizon import DownwashHorizon
from q2q_control.mpc.problem.horizon import Horizon
from q2q_control.mpc.problem.lq_problem import LqProblem
from q2q_model.compiled import compiled
from q2q_model.signals.values import Array

Rows = NDArray[np.intp]
_ENTRIES = (np.array([0, 0, 0, 1, 1, 2]), np.array([0, 1, 2, 1, 2, 2]))
"""Rows and columns of a chain's transition that are not zero."""


Slopes = tuple[Rows, Rows, Array]
"""i, j (pairs,) and slope (pairs, N, 3, 3) of a DownwashHorizon, as compiled code takes them."""


class GroupShape(NamedTuple):
    """Structure shared by problems of equal vehicle count and axes."""

    axes: Rows
    """(a,), of 0 1 2: x y z."""
    rows: NDArray[np.int64]
    cols: NDArray[np.int64]
    values: Array
    """(N, e): the chains; the entries of slopes are 0."""
    first_slope: int
    """Where the slopes' entries start: two, position and velocity row, for each pair of chains."""
    push_gain: Array
    """(a, 3)"""
    input_gain: Array
    state_weight: Array
    terminal: Array
    input_weight: Array


def group_shape(
    size: int, axes: tuple[int, ...], models: tuple[Chain, Chain, Chain], stages: int
) -> GroupShape:
    """Return the shape of groups of `size` vehicles; `models` are those of x, y, z."""
    own = [models[axis] for axis in axes] * size
    count = len(own)
    chain_rows = np.concatenate([_ENTRIES[0] + 3 * c for c in range(count)])
    chain_cols = np.concatenate([_ENTRIES[1] + 3 * c for c in range(count)])
    pairs = [(feels, moves) for feels in range(count) for moves in range(count)]
    slope_rows = np.array([row for feels, _ in pairs for row in (3 * feels, 3 * feels + 1)])
    slope_cols = np.array([3 * moves for _, moves in pairs for _ in range(2)])
    entries = np.concatenate([model.transition[_ENTRIES] for model in own])
    return GroupShape(
        axes=np.array(axes, np.intp),
        rows=np.concatenate([chain_rows, slope_rows]),
        cols=np.concatenate([chain_cols, slope_cols]),
        values=np.tile(np.concatenate([entries, np.zeros(2 * len(pairs))]), (stages, 1)),
        first_slope=entries.size,
        push_gain=np.stack([models[axis].push_gain for axis in axes]),
        input_gain=np.stack([model.input_gain for model in own]),
        state_weight=np.stack([model.state_weight for model in own]),
        terminal=np.stack([model.terminal for model in own]),
        input_weight=np.stack([model.input_weight for model in own]),
    )


def joint_problem(
    shape: GroupShape, vehicles: Rows, horizon: Horizon, downwash: DownwashHorizon
) -> LqProblem:
    """Return the problem of the group `vehicles` (g,), chains vehicle by vehicle, axis by axis."""
    return LqProblem(*joint_parts(shape, vehicles, horizon, (downwash.i, downwash.j, downwash.slope)))


@compiled
def joint_parts(shape: GroupShape, vehicles: Rows, horizon: Horizon, slopes: Slopes) -> LqProblem:
    """Return the LqProblem of (shape, vehicles (g,), horizon, slopes)."""
    axes = shape.axes
    chains, stages = vehicles.size * axes.size, horizon.push.shape[1]
    values, start, step = shape.values.copy(), np.empty(3 * chains), np.empty(chains)
    drift, target = np.empty((stages, 3 * chains)), np.empty((stages + 1, 3 * chains))
    wanted, low, high = np.empty((stages, chains)), np.empty((stages, chains)), np.empty((stages, chains))
    _fill_chains(horizon, (vehicles, axes), shape.push_gain, (drift, target, wanted))
    _fill_bounds(horizon, (vehicles, axes), (start, low, high, step))
    place = np.full(horizon.path.shape[0], -1)
    for g in range(vehicles.size):
        place[vehicles[g]] = g
    _fill_slopes(slopes, (place, axes, shape.push_gain), horizon.path, (values, drift), shape.first_slope)
    return LqProblem(
        start,
        shape.rows,
        shape.cols,
        values,
        drift,
        shape.input_gain,
        shape.state_weight,
        shape.terminal,
        target,
        shape.input_weight,
        wanted,
        low,
        high,
        step,
    )


@compiled
def _fill_bounds(horizon: Horizon, chains: tuple[Rows, Rows], out: tuple[Array, Array, Array, Array]) -> None:
    vehicles, axes = chains
    start, low, high, step = out
    for g in range(vehicles.size):
        for a in range(axes.size):
            v, axis, c = vehicles[g], axes[a], g * axes.size + a
            step[c] = horizon.step[axis]
            for row in range(3):
                start[3 * c + row] = horizon.start[v, axis, row]
            for k in range(low.shape[0]):
                low[k, c], high[k, c] = horizon.low[v, axis], horizon.high[v, axis]


@compiled
def _fill_chains(
    horizon: Horizon, chains: tuple[Rows, Rows], push_gain: Array, out: tuple[Array, Array, Array]
) -> None:
    vehicles, axes = chains
    drift, target, wanted = out
    stages = horizon.push.shape[1]
    for g in range(vehicles.size):
        for a in range(axes.size):
            v, axis, c = vehicles[g], axes[a], g * axes.size + a
            for k in range(stages + 1):
                w = horizon.push[v, min(k, stages - 1), axis]
                goal = horizon.reference[v, k, 6 + axis] - w
                target[k, 3 * c] = horizon.reference[v, k, axis]
                target[k, 3 * c + 1] = horizon.reference[v, k, 3 + axis]
                target[k, 3 * c + 2] = goal
                if k < stages:
                    wanted[k, c] = goal
                    for row in range(3):
                        drift[k, 3 * c + row] = push_gain[a, row] * w


@compiled
def _fill_slopes(
    slopes: tuple[Rows, Rows, Array],
    group: tuple[Rows, Rows, Array],
    path: Array,
    out: tuple[Array, Array],
    first: int,
) -> None:
    """Add what each pair's slopes do: to the transition, and minus G r~ to the drift."""
    place, axes, push_gain = group
    values, drift = out
    count = axes.size
    chains = drift.shape[1] // 3
    for pair in range(slopes[0].size):
        i, j = slopes[0][pair], slopes[1][pair]
        if place[i] < 0:
            continue
        for a in range(count):
            feels = place[i] * count + a
            for b in range(count):
                for side in range(2):
                    vehicle, sign = (i, -1.0) if side == 0 else (j, 1.0)
                    if place[vehicle] < 0:
                        continue
                    entry = first + 2 * (feels * chains + place[vehicle] * count + b)
                    for k in range(drift.shape[0]):
                        slope = sign * slopes[2][pair, k, axes[a], axes[b]]
                        for row in range(2):
                            pushed = push_gain[a, row] * slope
                            values[k, entry + row] += pushed
                            drift[k, 3 * feels + row] -= pushed * path[vehicle, k, axes[b]]
