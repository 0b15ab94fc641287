"""State history of the vehicles as a ring, one slot a physics step, for downwash that arrives late; compiled.

Between the step that writes a state and the one that reads it, many others leave the caches: `recall`
prefetches what the next step reads.
"""

import math

import numpy as np

from q2q_model.compiled import HOT, compiled
from q2q_model.signals.values import Array, Rows
from q2q_sim.plant.body.state_row import F1, F2, F3, F4, QW, QX, QY, QZ, VX, VY, X, Y, Z
from q2q_sim.plant.push.prefetch import prefetch

THRUST_RATIO = 3
"""Column of T / (m g) in a slot, after x, y, z [m]."""
LAW_WIDTH = 4
"""Number of columns in the air of a wake law."""
SPEED_X, SPEED_Y, SLOPE_X, SLOPE_Y = 4, 5, 6, 7
"""Further columns in the air of a room: velocity [m/s], slope of the body z axis [-]."""
ROOM_WIDTH = 8
STEEPEST = 0.6
"""Largest slope of a jet [-]: 31 degrees."""
LINE = 64
"""Bytes of a line of a cache: a source's columns in the air of a room."""


def empty_ring(shape: tuple[int, ...]) -> Array:
    """Return a ring that begins with a line of the cache: half as many are read as without."""
    size = 8 * math.prod(shape)
    room = np.empty(size + LINE, dtype=np.uint8)
    first = -room.ctypes.data % LINE
    return room[first : first + size].view(np.float64).reshape(shape)


@compiled(**HOT)
def recall(ring: Array, now: int, vehicle: int, late: float, columns: Array) -> None:
    """Write a vehicle's columns `late` steps ago (ROOM_WIDTH,), and prefetch those that the next step needs.

    `ring` is (slots, n, ROOM_WIDTH), and `now` the present's slot.
    """
    whole = int(late)
    old = late - whole
    new = 1.0 - old
    a = now - whole if now >= whole else now - whole + ring.shape[0]
    b = a - 1 if a > 0 else ring.shape[0] - 1
    prefetch(ring, a + 1 if a + 1 < ring.shape[0] else 0, vehicle)
    for k in range(ROOM_WIDTH):
        columns[k] = new * ring[a, vehicle, k] + old * ring[b, vehicle, k]


@compiled(**HOT)
def remember(state: Array, ring: Array, rows: Rows, weight: float) -> None:
    """Count the step in rows[n], and write its states into slot rows[n] % slots of `ring`.

    `state` is (n, STATE_WIDTH), `rows` (n + 1,), `ring` (slots, n, columns); `weight` is m g [N].
    """
    n, slots = state.shape[0], ring.shape[0]
    rows[n] += 1
    slot, following = rows[n] % slots, (rows[n] + 1) % slots
    for i in range(n):
        prefetch(ring, following, i)
        ring[slot, i, X], ring[slot, i, Y], ring[slot, i, Z] = state[i, X], state[i, Y], state[i, Z]
        ring[slot, i, THRUST_RATIO] = (state[i, F1] + state[i, F2] + state[i, F3] + state[i, F4]) / weight
        if ring.shape[2] == ROOM_WIDTH:
            x, y, z, w = state[i, QX], state[i, QY], state[i, QZ], state[i, QW]
            upright = max(1.0 - 2.0 * (x * x + y * y), 0.5)
            ring[slot, i, SPEED_X], ring[slot, i, SPEED_Y] = state[i, VX], state[i, VY]
            ring[slot, i, SLOPE_X] = min(max(2.0 * (x * z + w * y) / upright, -STEEPEST), STEEPEST)
            ring[slot, i, SLOPE_Y] = min(max(2.0 * (y * z - w * x) / upright, -STEEPEST), STEEPEST)
