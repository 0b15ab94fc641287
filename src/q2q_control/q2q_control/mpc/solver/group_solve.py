"""Problem of one group built and solved in one compiled call.

Selecting a group's rows and columns in Python would cost more than building the problem. A test compares it
with the two separate calls of `joint_problem` and `solve`.
"""

from typing import NamedTuple

import numpy as np

from q2q_control.mpc.problem.horizon import DownwashHorizon, Horizon, HorizonSolution
from q2q_control.mpc.problem.joint_problem import GroupShape, joint_problem
from q2q_control.mpc.solver.active_set import ActiveSet
from q2q_control.mpc.solver.riccati import solve_from
from q2q_model.compiled import compiled
from q2q_model.signals.values import Rows


class Group(NamedTuple):
    """Vehicles and axes that are solved together."""

    shape: GroupShape
    vehicles: Rows
    """(g,)"""
    iterations: int
    """Recursions at most."""


class GroupResult(NamedTuple):
    """Effort and outcome of a group's solve."""

    iterations: int
    finite: bool


@compiled
def solve_group(
    group: Group,
    horizon: Horizon,
    downwash: DownwashHorizon,
    warm_start: ActiveSet,
    solution: HorizonSolution,
) -> GroupResult:
    """Write the group's rows of `solution`; `warm_start` (n, N, 3) is an active set."""
    shape, vehicles = group.shape, group.vehicles
    stages, count = horizon.push.shape[1], shape.axes.size
    active_set = np.empty((stages, vehicles.size * count), np.int8)
    for g in range(vehicles.size):
        for a in range(count):
            for k in range(stages):
                active_set[k, g * count + a] = warm_start[vehicles[g], k, shape.axes[a]]
    found = solve_from(joint_problem(shape, vehicles, horizon, downwash), active_set, group.iterations)
    finite = True
    for g in range(vehicles.size):
        for a in range(count):
            v, axis, c = vehicles[g], shape.axes[a], g * count + a
            solution.pos[v, stages, axis] = found.states[stages, 3 * c]
            for k in range(stages):
                solution.pos[v, k, axis] = found.states[k, 3 * c]
                solution.inputs[v, k, axis] = found.inputs[k, c]
                solution.active_set[v, k, axis] = active_set[k, c]
                finite = finite and np.isfinite(found.inputs[k, c])
    return GroupResult(found.iterations, finite)
