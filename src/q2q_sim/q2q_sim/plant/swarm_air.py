"""Air around a swarm, and its push on every vehicle in a compiled step.

The air is a wake law (push/wake_law_push.py), that of a room (push/room_air_push.py), or a class outside the
loop (push/uncompiled_wake.py), asked between single steps. Both loops over pairs sort the vehicles by x.
States of the last 0.4 s are kept in a ring buffer, one slot a step, for delayed downwash; between slots they
are interpolated.
"""

import math
from typing import NamedTuple

import numpy as np

from q2q_model.compiled import HOT, compiled
from q2q_model.signals.values import Array, Rows
from q2q_model.vehicle.constants import GRAVITY
from q2q_sim.air.lookup.find_air import FlownAir
from q2q_sim.air.room_air import RoomAir
from q2q_sim.air.wake_laws import MAX_DELAY, WakeLaw, max_delay
from q2q_sim.plant.body.quadcopter import Body
from q2q_sim.plant.body.state_row import POS, ROTORS, X
from q2q_sim.plant.push.compiled_room_air import CompiledRoomAir, compiled_room_air
from q2q_sim.plant.push.room_air_push import room_air_push
from q2q_sim.plant.push.state_history_ring import LAW_WIDTH, ROOM_WIDTH, empty_ring
from q2q_sim.plant.push.wake_law_push import wake_law_push

ROOM, UNCOMPILED = 3, 4
"""Kinds of air besides those of WakeLaw: a RoomAir, and a Wake outside the compiled loop."""


class Air(NamedTuple):
    """Air in compiled code, with the past states of the sources."""

    kind: int
    """A WakeLaw, ROOM or UNCOMPILED."""
    ring: Array
    """x, y, z [m] and T / (m g) at each past step, (slots, n, 4); in a room all columns of
    state_history_ring."""
    rows: Rows
    """Rows by rising x at the last step, then the number of steps taken, (n + 1,); the present is slot
    steps % slots."""
    room: CompiledRoomAir
    """Empty if the kind is not ROOM."""


@compiled(**HOT)
def air_push(state: Array, air: Air, body: Body) -> None:
    """Write push [m/s^2] and torque [N m] of the air into the rows of `state` (n, STATE_WIDTH)."""
    kind, ring, rows, room = air
    if kind == ROOM:
        room_air_push(state, ring, rows, room, body.mass)
    elif kind != UNCOMPILED:
        wake_law_push(state, ring, rows, kind, body.step)


def still_air(state: Array, air: FlownAir, body: Body, seed: int = 0) -> Air:
    """Return the air around vehicles that have always hovered at their present positions."""
    order = np.append(np.argsort(state[:, X], kind="stable"), 0).astype(np.intp)
    now = np.column_stack([state[:, POS], state[:, ROTORS].sum(axis=1) / (body.mass * GRAVITY)])  # (n, 4)
    kind, delay, room = UNCOMPILED, 0.0, compiled_room_air(RoomAir(), 0, body, seed)
    if isinstance(air, RoomAir):
        kind, delay, room = ROOM, MAX_DELAY, compiled_room_air(air, len(state), body, seed)
        now = np.column_stack([now, np.zeros((len(state), ROOM_WIDTH - LAW_WIDTH))])
    elif isinstance(air, WakeLaw):
        kind, delay = int(air), max_delay(air)
    slots = math.ceil(delay / body.step) + 2
    ring = empty_ring((slots, *now.shape))
    ring[:] = now
    return Air(kind, ring, order, room)
