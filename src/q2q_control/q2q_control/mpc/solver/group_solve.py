"""Problem of one group built and solved in one compiled call.

Selecting a group's rows and columns in Python would cost more than building the problem. A test compares it
with the two separate calls of `joint_problem` and `solve`.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from q2q_control.mpc.prediction.downwash_horizon_kernel import DownwashHorizon
from q2q_control.mpc.problem.horizon import Horizon, HorizonSolution
from q2q_control.mpc.problem.joint_problem import GroupShape, joint_problem
from q2q_control.mpc.solver.riccati import solve_from
from q2q_model.compiled import compiled

Modes = NDArray[np.int8]


class Group(NamedTuple):
    """Vehicles and axes that are solved together."""

    shape: GroupShape
    vehicles: NDArray[np.intp]
    """(g,)"""
    iterations: int
    """Recursions at most."""


class GroupResult(NamedTuple):
    """Effort and outcome of a group's solve."""

    iterations: int
    converged: bool
    finite: bool


@compiled
def solve_group(
    group: Group, horizon: Horizon, downwash: DownwashHorizon, guess: Modes, solution: HorizonSolution
) -> GroupResult:
    """Write the group's rows of `solution`; `guess` (n, N, 3) is a pattern of active bounds."""
    shape, vehicles = group.shape, group.vehicles
    stages, count = horizon.push.shape[1], shape.axes.size
    modes = np.empty((stages, vehicles.size * count), np.int8)
    for g in range(vehicles.size):
        for a in range(count):
            for k in range(stages):
                modes[k, g * count + a] = guess[vehicles[g], k, shape.axes[a]]
    found = solve_from(joint_problem(shape, vehicles, horizon, downwash), modes, group.iterations)
    finite = True
    for g in range(vehicles.size):
        for a in range(count):
            v, axis, c = vehicles[g], shape.axes[a], g * count + a
            solution.pos[v, stages, axis] = found.states[stages, 3 * c]
            for k in range(stages):
                solution.pos[v, k, axis] = found.states[k, 3 * c]
                solution.inputs[v, k, axis] = found.inputs[k, c]
                solution.pattern[v, k, axis] = modes[k, c]
                finite = finite and np.isfinite(found.inputs[k, c])
    return GroupResult(found.iterations, found.converged, finite)
