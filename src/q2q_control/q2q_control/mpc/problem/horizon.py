"""Problem of one tick, its downwash and its solution: all vehicles, all axes, all stages.

All are NamedTuples, which compiled code can take.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from q2q_model.signals.values import Array, Rows

SOLVED, INTERRUPTED = 0, 1
"""Status of a vehicle's solution: optimal, or feasible though not optimal; out of time or not finite."""


class Horizon(NamedTuple):
    """Problem of one tick for n vehicles and N stages; world frame."""

    start: Array
    """Position [m], velocity [m/s], acceleration by thrust [m/s^2] of each axis, (n, 3 axes, 3)."""
    reference: Array
    """Position [m], velocity [m/s], acceleration [m/s^2], (n, N + 1, 9)."""
    push: Array
    """Downwash and disturbance along the last prediction [m/s^2], (n, N, 3)."""
    path: Array
    """Last predicted positions [m] of the n vehicles and of others, (n or more, N + 1, 3)."""
    low: Array
    """Minimum input of each axis [m/s^2], (n, 3)."""
    high: Array
    """Largest input of each axis at each stage [m/s^2], (n, N, 3)."""
    slew_max: Array
    """Largest difference of input and acceleration [m/s^2], (3,)."""


class DownwashHorizon(NamedTuple):
    """Predicted downwash accelerations and their gradients."""

    eta: Array
    """[m/s^2], world, (n, N, 3)."""
    i: Rows
    """(p,)"""
    j: Rows
    """(p,)"""
    gradient: Array
    """[1/s^2], (p, N, 3, 3): row feels, column moves."""


class HorizonSolution(NamedTuple):
    """Solution of one tick's problem."""

    pos: Array
    """Predicted positions [m], world, (n, N + 1, 3)."""
    inputs: Array
    """Commanded accelerations [m/s^2], world, (n, N, 3)."""
    active_set: NDArray[np.int8]
    """Active bounds (q2q_control.mpc.solver.active_set), (n, N, 3)."""
    status: NDArray[np.int8]
    """SOLVED or INTERRUPTED, (n,)."""
    iterations: int
    """Most recursions of one problem."""


PlainHorizon = tuple[Array, Array, Array, Array, Array, Array, Array]
"""Fields of a Horizon, which numba takes from Python in less than half the time."""
PlainDownwash = tuple[Array, Rows, Rows, Array]
"""Fields of a DownwashHorizon."""
PlainSolution = tuple[Array, Array, NDArray[np.int8], NDArray[np.int8], int]
"""Fields of a HorizonSolution."""


def blank_solution(vehicles: int, stages: int) -> HorizonSolution:
    """Return a solution to be filled: no active bounds, every vehicle SOLVED."""
    return HorizonSolution(
        pos=np.empty((vehicles, stages + 1, 3)),
        inputs=np.empty((vehicles, stages, 3)),
        active_set=np.zeros((vehicles, stages, 3), np.int8),
        status=np.zeros(vehicles, np.int8),  # SOLVED
        iterations=1,
    )
