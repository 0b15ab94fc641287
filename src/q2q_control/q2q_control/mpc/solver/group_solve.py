"""Problem of one group built and solved in one compiled call.

Selecting a group's rows and columns in Python would cost more than building the problem. A test compares it
with the two separate calls of `joint_problem` and `solve`.
"""

from typing import NamedTuple

import numpy as np

from q2q_control.mpc.problem.horizon import (
    DownwashHorizon,
    Horizon,
    HorizonSolution,
    PlainDownwash,
    PlainHorizon,
    PlainSolution,
)
from q2q_control.mpc.problem.joint_problem import GroupShape, PlainShape, joint_problem
from q2q_control.mpc.solver.active_set import ActiveSet
from q2q_control.mpc.solver.riccati import solve_from
from q2q_model.compiled import compiled
from q2q_model.signals.values import Rows


class Group(NamedTuple):
    """Vehicles and axes that are solved together."""

    shape: PlainShape
    vehicles: Rows
    """(g,)"""
    iterations: int
    """Recursions at most."""


PlainGroup = tuple[PlainShape, Rows, int]
"""Fields of a Group."""


@compiled
def solve_group(
    group: PlainGroup,
    warm_start: ActiveSet,
    horizon: PlainHorizon,
    downwash: PlainDownwash,
    solution: PlainSolution,
) -> tuple[int, bool]:
    """Write the group's rows of `solution`; `warm_start` (n, N, 3) is an active set.

    Returns:
        Recursions of the solve, and whether all inputs are finite.
    """
    shape, vehicles, iterations = GroupShape(*group[0]), group[1], group[2]
    problem = joint_problem(shape, vehicles, Horizon(*horizon), DownwashHorizon(*downwash))
    out, count = HorizonSolution(*solution), shape.axes.size
    stages = out.inputs.shape[1]
    active_set = np.empty((stages, vehicles.size * count), np.int8)
    for g in range(vehicles.size):
        for a in range(count):
            for k in range(stages):
                active_set[k, g * count + a] = warm_start[vehicles[g], k, shape.axes[a]]
    found = solve_from(problem, active_set, iterations)
    finite = True
    for g in range(vehicles.size):
        for a in range(count):
            v, axis, c = vehicles[g], shape.axes[a], g * count + a
            out.pos[v, stages, axis] = found.states[stages, 3 * c]
            for k in range(stages):
                out.pos[v, k, axis] = found.states[k, 3 * c]
                out.inputs[v, k, axis] = found.inputs[k, c]
                out.active_set[v, k, axis] = active_set[k, c]
                finite = finite and np.isfinite(found.inputs[k, c])
    return found.iterations, finite
