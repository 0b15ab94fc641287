"""Build and solve the problem of one group in one compiled call, from the horizon's arrays into the answer's.

What Python would do between building and solving, the choice of a group's rows and columns, costs more than
building. The twin of two calls, `joint_problem` and `solve`, that a test compares.
"""

import numpy as np
from numpy.typing import NDArray

from q2q_control.mpc.problem.horizon import Horizon
from q2q_control.mpc.problem.joint_problem import GroupShape, Slopes, joint_parts
from q2q_control.mpc.solver.riccati import solve_from
from q2q_model.compiled import compiled
from q2q_model.signals.values import Array

Rows = NDArray[np.intp]
Modes = NDArray[np.int8]


@compiled
def solve_group(
    group: tuple[GroupShape, Rows],
    horizon: Horizon,
    slopes: Slopes,
    found: tuple[Modes, Array, Array, Modes],
    iterations: int,
) -> tuple[int, bool, bool]:
    """Write the solution of a group; return its recursions, whether it is optimal, whether it is finite.

    Args:
        group: shape and vehicles (g,).
        horizon: of all vehicles.
        slopes: of all pairs.
        found: guess (n, N, 3), pos (n, N + 1, 3), inputs and pattern (n, N, 3).
        iterations: recursions at most.
    """
    shape, vehicles = group
    guess, pos, inputs, pattern = found
    stages, count = horizon.push.shape[1], shape.axes.size
    modes = np.empty((stages, vehicles.size * count), np.int8)
    for g in range(vehicles.size):
        for a in range(count):
            for k in range(stages):
                modes[k, g * count + a] = guess[vehicles[g], k, shape.axes[a]]
    problem = joint_parts(shape, vehicles, horizon, slopes)
    states, acting, used, converged = solve_from(problem, modes, iterations)
    finite = True
    for g in range(vehicles.size):
        for a in range(count):
            v, axis, c = vehicles[g], shape.axes[a], g * count + a
            pos[v, stages, axis] = states[stages, 3 * c]
            for k in range(stages):
                pos[v, k, axis], inputs[v, k, axis] = states[k, 3 * c], acting[k, c]
                pattern[v, k, axis] = modes[k, c]
                finite = finite and np.isfinite(acting[k, c])
    return used, converged, finite
