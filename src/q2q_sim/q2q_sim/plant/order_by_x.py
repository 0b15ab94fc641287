"""Order of vehicles by x: insertion sort from the order of the last step, which hardly changes."""

import numpy as np
from numpy.typing import NDArray

from q2q_model.compiled import BORROWING, compiled
from q2q_model.signals.values import Array
from q2q_sim.plant.quadcopter import X

Rows = NDArray[np.int64]


@compiled(**BORROWING)
def sort_by_x(state: Array, rows: Rows) -> None:
    """Sort the first n entries of rows (n + 1,) by the x of their states."""
    for a in range(1, state.shape[0]):
        row = rows[a]
        b = a - 1
        while b >= 0 and state[rows[b], X] > state[row, X]:
            rows[b + 1] = rows[b]
            b -= 1
        rows[b + 1] = row
