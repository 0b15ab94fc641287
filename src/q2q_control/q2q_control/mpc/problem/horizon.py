"""Hold what one tick asks of the horizon, and what the answer is: all vehicles, all axes, all stages.

A Horizon is a NamedTuple and not a dataclass, because compiled code takes it as it is.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from q2q_model.signals.values import Array

INTERRUPTED, SOLVED, CUT_OFF = 0, 1, 2
"""How a vehicle's horizon ended: not reached in time or not finite, optimal, bounds kept but not optimal."""


class Horizon(NamedTuple):
    """Problem of one tick for n vehicles and N stages; world frame."""

    start: Array
    """Position [m], velocity [m/s], acceleration by thrust [m/s^2] of each axis, (n, 3 axes, 3)."""
    reference: Array
    """Position [m], velocity [m/s], acceleration [m/s^2], (n, N + 1, 9)."""
    push: Array
    """Downwash and disturbance along the last prediction [m/s^2], (n, N, 3)."""
    path: Array
    """Last predicted positions [m] of the n and of others, (n or more, N + 1, 3)."""
    low: Array
    """Least input of each axis [m/s^2], (n, 3)."""
    high: Array
    """Largest input [m/s^2], (n, 3)."""
    step: Array
    """Largest difference of input and acceleration [m/s^2], (3,)."""


@dataclass(frozen=True, slots=True)
class HorizonSolution:
    """Solution of one tick's problem."""

    pos: Array
    """Predicted positions [m], world, (n, N + 1, 3)."""
    inputs: Array
    """Commanded accelerations [m/s^2], world, (n, N, 3)."""
    pattern: NDArray[np.int8]
    """Active bounds (q2q_control.mpc.solver.riccati), (n, N, 3)."""
    ended: NDArray[np.int8]
    """INTERRUPTED, SOLVED or CUT_OFF, (n,)."""
    iterations: int
    """Most recursions that one problem took."""
