"""Push and torque of all jets of a room on the vehicles in them, compiled (q2q_sim.air.room_air).

For each source, by rising x, the jet acts on each vehicle in it with what those between have transmitted.
Arguments are those of room_air_push.py; `jet_rows` is that of CompiledRoomAir.
"""

import math

from q2q_model.compiled import HOT, compiled
from q2q_model.signals.values import Array, Rows
from q2q_model.vehicle.constants import GRAVITY
from q2q_sim.plant.body.state_row import ETA_Z, QW, QX, QY, QZ, TX, TY, TZ, X, Y, Z
from q2q_sim.plant.push.compiled_room_air import (
    AT_ONCE,
    AWAY_X,
    AWAY_Y,
    FALL,
    PUSH,
    RADIUS,
    STRENGTH,
    TRANSMITTED,
    WEIGHT,
    CompiledRoomAir,
    RoomNumbers,
)
from q2q_sim.plant.push.jet_pairs import Now, add_pairs_in_reach, keep_pairs_in_jet
from q2q_sim.plant.push.jet_reach import reach_of, update_extremes
from q2q_sim.plant.push.neighbour_list import update


@compiled(**HOT)
def write_transmitted(jet_rows: Array, first: int, end: int, one: RoomNumbers) -> None:
    """Write the share of a jet [-] that each vehicle in it, of pairs `first` to `end`, transmits below."""
    for k in range(first, end):
        aside = jet_rows[k, RADIUS] / one.absorbing_width
        taken = max(one.absorbed * math.exp(-0.5 * aside * aside), jet_rows[k, PUSH] / GRAVITY)
        jet_rows[k, TRANSMITTED] = 1.0 - min(jet_rows[k, WEIGHT] * taken, 1.0)


@compiled(**HOT)
def edge_torque(jet_rows: Array, k: int, strength: float, one: RoomNumbers) -> tuple[float, float]:
    """Return the edge torque of the k-th pair's jet, of a `strength` [-], about world x and y [N m]."""
    ratio = jet_rows[k, RADIUS] / one.torque_radius
    torque = one.torque * strength * ratio * math.exp(0.5 * (1.0 - ratio * ratio))
    return torque * jet_rows[k, AWAY_Y], -torque * jet_rows[k, AWAY_X]


@compiled(**HOT)
def add_torque(state: Array, i: int, tx: float, ty: float) -> None:
    """Add a torque about world x and y [N m] to the row of vehicle i, in body axes."""
    x, y, z, w = state[i, QX], state[i, QY], state[i, QZ], state[i, QW]
    state[i, TX] += (1.0 - 2.0 * (y * y + z * z)) * tx + 2.0 * (x * y + w * z) * ty
    state[i, TY] += 2.0 * (x * y - w * z) * tx + (1.0 - 2.0 * (x * x + z * z)) * ty
    state[i, TZ] += 2.0 * (x * z + w * y) * tx + 2.0 * (y * z - w * x) * ty


@compiled(**HOT)
def add_source_jet(state: Array, room: CompiledRoomAir, first: int, end: int) -> None:
    """Add push [m/s^2] and torque [N m] of a source's jet to the vehicles in it, and the push on the source.

    They are those of the pairs `first` to before `end`.
    """
    one, jet_rows, receiver, j = room.numbers, room.jet_rows, room.receiver, room.source[first]
    absorbing = end > first + 1 and one.absorbed > 0.0
    if absorbing:
        write_transmitted(jet_rows, first, end, one)
    for k in range(first, end):
        strength = jet_rows[k, STRENGTH]
        if absorbing:
            for between in range(first, end):
                if jet_rows[between, FALL] < jet_rows[k, FALL]:
                    strength *= jet_rows[between, TRANSMITTED]
        i, push = receiver[k], strength * room.gains[receiver[k]] * jet_rows[k, PUSH]
        state[i, ETA_Z] -= push
        state[j, ETA_Z] += one.upper_ratio * push
        if one.torque != 0.0:
            tx, ty = edge_torque(jet_rows, k, strength, one)
            add_torque(state, i, tx, ty)


@compiled(**HOT)
def add_jets(state: Array, ring: Array, rows: Rows, room: CompiledRoomAir) -> None:
    """Add push [m/s^2] and torque [N m] of the jets of all vehicles."""
    n, places = state.shape[0], room.places
    past = update_extremes(state, ring, rows, room.extremes)
    for i in range(n):
        places[X, i], places[Y, i], places[Z, i] = state[i, X], state[i, Y], state[i, Z]
    found = room.near.found if update(room.near, places, rows, room.bound, past) else rows
    now = Now(rows[n] % ring.shape[0], rows[n] % room.unit.shape[1])
    to = reach_of(room.bound, past)
    chosen = 0
    for a in range(n):
        chosen = add_pairs_in_reach(found, room, rows[a], chosen, to)
        if chosen >= AT_ONCE or a == n - 1:
            count, chosen, first = keep_pairs_in_jet(ring, room, chosen, now), 0, 0
            while first < count:
                end = first + 1
                while end < count and room.source[end] == room.source[first]:
                    end += 1
                add_source_jet(state, room, first, end)
                first = end
