"""Ring of past states of the vehicles, one slot a physics step, for downwash that arrives late; compiled."""

from q2q_model.compiled import BORROWING, compiled
from q2q_model.signals.values import Array
from q2q_sim.plant.order_by_x import Rows
from q2q_sim.plant.quadcopter import F1, F2, F3, F4, QW, QX, QY, QZ, VX, VY, X, Y, Z

SHARE = 3
"""Column of T / (m g) in a slot, after x, y, z [m]."""
LAW_WIDTH = 4
"""Number of columns in the air of a wake law."""
SPEED_X, SPEED_Y, SLOPE_X, SLOPE_Y = 4, 5, 6, 7
"""Further columns in the air of a room: velocity [m/s], slope of the body z axis [-]."""
ROOM_WIDTH = 8
STEEPEST = 0.6
"""Largest slope of a jet [-]: 31 degrees."""


@compiled(**BORROWING)
def remember(state: Array, ring: Array, rows: Rows, weight: float) -> None:
    """Count the step in rows[n] and write its states into slot rows[n] % slots; `weight` is m g [N]."""
    n, slots = state.shape[0], ring.shape[0]
    rows[n] += 1
    slot = rows[n] % slots
    for i in range(n):
        ring[slot, i, X], ring[slot, i, Y], ring[slot, i, Z] = state[i, X], state[i, Y], state[i, Z]
        ring[slot, i, SHARE] = (state[i, F1] + state[i, F2] + state[i, F3] + state[i, F4]) / weight
        if ring.shape[2] == ROOM_WIDTH:
            x, y, z, w = state[i, QX], state[i, QY], state[i, QZ], state[i, QW]
            upright = max(1.0 - 2.0 * (x * x + y * y), 0.5)
            ring[slot, i, SPEED_X], ring[slot, i, SPEED_Y] = state[i, VX], state[i, VY]
            ring[slot, i, SLOPE_X] = min(max(2.0 * (x * z + w * y) / upright, -STEEPEST), STEEPEST)
            ring[slot, i, SLOPE_Y] = min(max(2.0 * (y * z - w * x) / upright, -STEEPEST), STEEPEST)
