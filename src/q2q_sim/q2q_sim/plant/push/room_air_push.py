"""Push and torque of a room's air on every vehicle, compiled: the equations of q2q_sim.air.room_air.

For each source, the vehicles in its jet are collected from those near it, by rising x, and the jet acts on
each with what those between have transmitted. Then each vehicle feels the residual, the ground and the drag
of its rotors, whose largest thrusts the load of its rates lowers.
"""

import math
from typing import NamedTuple

from q2q_model.compiled import HOT, compiled
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import GRAVITY
from q2q_sim.air.room_air import INSIDE
from q2q_sim.air.unit_processes import MEANDER_X, MEANDER_Y, RESIDUAL
from q2q_sim.air.wake_laws import BLEND, MAX_DELAY
from q2q_sim.plant.body.rotors import rotor_torque
from q2q_sim.plant.body.state_row import (
    ETA_X,
    ETA_Y,
    ETA_Z,
    F1,
    F2,
    F3,
    F4,
    QW,
    QX,
    QY,
    QZ,
    ROTOR_MAX1,
    ROTOR_MAX2,
    ROTOR_MAX3,
    ROTOR_MAX4,
    TX,
    TY,
    TZ,
    VX,
    VY,
    VZ,
    P,
    Q,
    Three,
    X,
    Y,
    Z,
)
from q2q_sim.plant.push.compiled_room_air import (
    AT_ONCE,
    AWAY_X,
    AWAY_Y,
    FALL,
    PAST,
    PUSH,
    RADIUS,
    STRENGTH,
    TAU,
    TRANSMITTED,
    WEIGHT,
    CompiledRoomAir,
    RoomNumbers,
    cell,
    table_push,
)
from q2q_sim.plant.push.insertion_sort import Rows
from q2q_sim.plant.push.jet_reach import JetReach, reach, reach_of, update_extremes
from q2q_sim.plant.push.neighbour_list import update
from q2q_sim.plant.push.state_history_ring import SLOPE_X, SLOPE_Y, SPEED_X, SPEED_Y, THRUST_RATIO, recall

TOUCHING = 1e-9
"""Distance from the axis below which its direction is taken as zero [m]."""


class Now(NamedTuple):
    """Present step."""

    slot: int
    """Of the ring."""
    tick: int
    """Of the block of unit processes."""


@compiled(**HOT)
def beside_axis(room: CompiledRoomAir, k: int, tick: int) -> Three:
    """Return the way from the jet's axis to the vehicle of the k-th pair along x and y, and its fall [m]."""
    one, jet_rows, places, i, j = room.numbers, room.jet_rows, room.places, room.receiver[k], room.source[k]
    kept, slope_x, slope_y = one.carried * jet_rows[k, TAU], one.bend_x, one.bend_y
    if one.meander != 0.0:
        slope_x += one.meander * room.unit[MEANDER_X, tick, j]
        slope_y += one.meander * room.unit[MEANDER_Y, tick, j]
    slope_x -= one.slope * jet_rows[k, PAST + SLOPE_X]
    slope_y -= one.slope * jet_rows[k, PAST + SLOPE_Y]
    dz = jet_rows[k, PAST + Z] - places[Z, i]
    down = max(dz, 0.0)
    away_x = places[X, i] - jet_rows[k, PAST + X] - kept * jet_rows[k, PAST + SPEED_X] - down * slope_x
    away_y = places[Y, i] - jet_rows[k, PAST + Y] - kept * jet_rows[k, PAST + SPEED_Y] - down * slope_y
    return away_x, away_y, dz


@compiled(**HOT)
def write_jet_row(room: CompiledRoomAir, k: int, kept: int, tick: int) -> bool:
    """Write what the k-th vehicle is for the jet into row `kept`; return whether it is in the jet."""
    one, table, jet_rows = room.numbers, room.table, room.jet_rows
    away_x, away_y, dz = beside_axis(room, k, tick)
    spread = max(dz / one.last_gap, 1.0)  # of the self-similar jet below the table
    radius = math.sqrt(away_x * away_x + away_y * away_y)
    gap = abs(dz) / spread
    a = cell(table.gaps, gap)
    if radius >= spread * table.ends[a]:
        return False
    along = min(max(0.5 * (dz / BLEND + 1.0), 0.0), 1.0)
    jet_rows[kept, FALL], jet_rows[kept, RADIUS] = dz, radius / spread
    jet_rows[kept, AWAY_X], jet_rows[kept, AWAY_Y] = (
        away_x / max(radius, TOUCHING),
        away_y / max(radius, TOUCHING),
    )
    jet_rows[kept, PUSH] = table_push(table, a, gap, radius / spread)
    jet_rows[kept, WEIGHT] = along * along * (3.0 - 2.0 * along) / (spread * spread)
    jet_rows[kept, STRENGTH] = jet_rows[kept, WEIGHT] * jet_rows[k, PAST + THRUST_RATIO]
    room.receiver[kept], room.source[kept] = room.receiver[k], room.source[k]
    return True


@compiled(**HOT)
def add_pairs_in_reach(found: Rows, room: CompiledRoomAir, j: int, count: int, to: JetReach) -> int:
    """Add the vehicles in reach of vehicle j to the pairs; return their number."""
    places, near = room.places, room.near
    x, y, z = places[X, j], places[Y, j], places[Z, j]
    for c in range(near.begin[j], near.end[j]):
        i = found[c]
        dx, dy, gap = places[X, i] - x, places[Y, i] - y, z - places[Z, i]
        if (i != j) & (gap > -BLEND) & (dx * dx + dy * dy <= reach(to, abs(gap)) ** 2):
            room.receiver[count], room.source[count] = i, j
            room.jet_rows[count, TAU] = min(max(gap, 0.0) / room.numbers.travel_speed, MAX_DELAY)
            count += 1
    return count


@compiled(**HOT)
def keep_pairs_in_jet(ring: Array, room: CompiledRoomAir, count: int, now: Now) -> int:
    """Keep of the pairs those with a vehicle in the jet; return their number."""
    for k in range(count):  # all pasts are read before a branch depends on one
        late = room.jet_rows[k, TAU] / room.numbers.step
        recall(ring, now.slot, room.source[k], late, room.jet_rows[k, PAST:])
    kept = 0
    for k in range(count):
        kept += write_jet_row(room, k, kept, now.tick)
    return kept


@compiled(**HOT)
def write_transmitted(jet_rows: Array, first: int, end: int, one: RoomNumbers) -> None:
    """Write the share of a jet that each vehicle in it transmits to those below."""
    for k in range(first, end):
        aside = jet_rows[k, RADIUS] / one.absorbing_width
        taken = max(one.absorbed * math.exp(-0.5 * aside * aside), jet_rows[k, PUSH] / GRAVITY)
        jet_rows[k, TRANSMITTED] = 1.0 - min(jet_rows[k, WEIGHT] * taken, 1.0)


@compiled(**HOT)
def edge_torque(jet_rows: Array, k: int, strength: float, one: RoomNumbers) -> tuple[float, float]:
    """Return the edge torque of a jet about world x and y [N m]."""
    ratio = jet_rows[k, RADIUS] / one.torque_radius
    torque = one.torque * strength * ratio * math.exp(0.5 * (1.0 - ratio * ratio))
    return torque * jet_rows[k, AWAY_Y], -torque * jet_rows[k, AWAY_X]


@compiled(**HOT)
def add_torque(state: Array, i: int, tx: float, ty: float) -> None:
    """Add a torque about world x and y to a vehicle's row, in body axes."""
    x, y, z, w = state[i, QX], state[i, QY], state[i, QZ], state[i, QW]
    state[i, TX] += (1.0 - 2.0 * (y * y + z * z)) * tx + 2.0 * (x * y + w * z) * ty
    state[i, TY] += 2.0 * (x * y - w * z) * tx + (1.0 - 2.0 * (x * x + z * z)) * ty
    state[i, TZ] += 2.0 * (x * z + w * y) * tx + 2.0 * (y * z - w * x) * ty


@compiled(**HOT)
def add_source_jet(state: Array, room: CompiledRoomAir, first: int, end: int) -> None:
    """Add the jet of a source to the vehicles in it, those of the pairs `first` to `end`."""
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
def add_residual(state: Array, i: int, unit: float, one: RoomNumbers) -> None:
    """Add the turbulence of the jets, `unit` its process, to the push on a vehicle."""
    eta = abs(state[i, ETA_Z])
    state[i, ETA_Z] += (one.floor * min(eta / INSIDE, 1.0) + one.growth * eta) * unit


@compiled(**HOT)
def add_ground_effect(state: Array, i: int, one: RoomNumbers, mass: float) -> None:
    """Add the ground effect to the push on a vehicle; no jet pushes along x and y."""
    near = one.rotor_radius / max(state[i, Z], one.ground_from)
    lift = one.ground * near * near * (state[i, F1] + state[i, F2] + state[i, F3] + state[i, F4]) / mass
    x, y, z, w = state[i, QX], state[i, QY], state[i, QZ], state[i, QW]
    state[i, ETA_X] = lift * 2.0 * (x * z + w * y)
    state[i, ETA_Y] = lift * 2.0 * (y * z - w * x)
    state[i, ETA_Z] += lift * (1.0 - 2.0 * (x * x + y * y))


@compiled(**HOT)
def add_rotor_drag(state: Array, i: int, per_s: float) -> None:
    """Add the drag of the rotors to the push on a vehicle: against its velocity across its thrust."""
    x, y, z, w = state[i, QX], state[i, QY], state[i, QZ], state[i, QW]
    bx, by, bz = 2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)
    vx, vy, vz = state[i, VX], state[i, VY], state[i, VZ]
    along = vx * bx + vy * by + vz * bz
    state[i, ETA_X] -= per_s * (vx - along * bx)
    state[i, ETA_Y] -= per_s * (vy - along * by)
    state[i, ETA_Z] -= per_s * (vz - along * bz)


@compiled(**HOT)
def subtract_rate_load(state: Array, i: int, one: RoomNumbers) -> None:
    """Subtract the load of a vehicle's rates from its rotors' largest thrusts, ahead by the lag of thrust."""
    rotors = state[i, F1], state[i, F2], state[i, F3], state[i, F4]
    tx, ty, _ = rotor_torque(rotors, one.lever, 0.0)
    roll = one.rate_load * (state[i, P] + one.roll_lead * (tx + state[i, TX]))
    pitch = one.rate_load * (state[i, Q] + one.pitch_lead * (ty + state[i, TY]))
    state[i, ROTOR_MAX1] += roll + pitch
    state[i, ROTOR_MAX2] += roll - pitch
    state[i, ROTOR_MAX3] -= roll + pitch
    state[i, ROTOR_MAX4] -= roll - pitch


@compiled(**HOT)
def clear_push(state: Array, rotor_max: Array, faded: float) -> None:
    """Write no push, no torque and the largest thrust of each rotor, less what faded, into every state."""
    for i in range(state.shape[0]):
        for column in range(ETA_Z, ROTOR_MAX1):
            state[i, column] = 0.0
        for rotor in range(4):
            state[i, ROTOR_MAX1 + rotor] = max(rotor_max[i, rotor] - faded, 0.0)


@compiled(**HOT)
def add_jets(state: Array, ring: Array, rows: Rows, room: CompiledRoomAir) -> None:
    """Add the jets of all vehicles."""
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


@compiled(**HOT)
def room_air_push(state: Array, ring: Array, rows: Rows, room: CompiledRoomAir, mass: float) -> None:
    """Write push, torque and largest rotor thrust of every vehicle; `mass` in [kg]."""
    n, one, unit = state.shape[0], room.numbers, room.unit
    clear_push(state, room.rotor_max, one.fading * one.step * float(rows[n]))
    if n > 1 and room.bound.near > 0.0:
        add_jets(state, ring, rows, room)
    tick = rows[n] % unit.shape[1]
    for i in range(n):
        add_residual(state, i, unit[RESIDUAL, tick, i], one)
        add_ground_effect(state, i, one, mass)
        if one.drag != 0.0:
            add_rotor_drag(state, i, one.drag)
        if one.rate_load != 0.0:
            subtract_rate_load(state, i, one)
