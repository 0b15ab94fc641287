"""Push and torque of a room's air on every vehicle, compiled: the equations of q2q_sim.air.room_air.

For each source, the vehicles in its jet are collected from the vehicles sorted by x, and the jet acts on each
with what those between have not absorbed. Then each vehicle feels the residual and the ground.
"""

import math
from typing import NamedTuple

from q2q_model.compiled import BORROWING, compiled
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import GRAVITY
from q2q_sim.air.room_air import INSIDE
from q2q_sim.air.unit_processes import RESIDUAL, WANDER_X, WANDER_Y
from q2q_sim.air.wake_laws import BLEND, MAX_DELAY
from q2q_sim.plant.jet_push import cell, table_push
from q2q_sim.plant.jet_reach import JetReach, reach, reach_of, watch
from q2q_sim.plant.order_by_x import Rows, sort_by_x
from q2q_sim.plant.past_states import SHARE, SLOPE_X, SLOPE_Y, SPEED_X, SPEED_Y
from q2q_sim.plant.quadcopter import (
    CEILING1,
    CEILING2,
    CEILING3,
    CEILING4,
    ETA,
    ETA_X,
    ETA_Y,
    F1,
    F2,
    F3,
    F4,
    QW,
    QX,
    QY,
    QZ,
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
    rotor_torque,
)
from q2q_sim.plant.room_law import (
    AWAY_X,
    AWAY_Y,
    FALL,
    LEFT,
    PUSH,
    RADIUS,
    STRENGTH,
    WEIGHT,
    RoomLaw,
    RoomNumbers,
)

TOUCHING = 1e-9
"""Distance from the axis below which its direction is taken as zero [m]."""


class Now(NamedTuple):
    """Present step."""

    slot: int
    """Of the ring."""
    tick: int
    """Of the block of unit processes."""
    across: float
    """Reach at the largest gap [m]."""
    reach: JetReach


class JetSource(NamedTuple):
    """Source of a jet when its air left."""

    x: float
    y: float
    z: float
    """[m]"""
    share: float
    """T / (m g)"""
    drift_x: float
    drift_y: float
    """Shift of the axis by the velocity of the source [m]."""
    slope_x: float
    slope_y: float
    """Slope of the axis [-]."""


@compiled(**BORROWING)
def past_source(ring: Array, now: Now, room: RoomLaw, j: int, tau: float) -> JetSource:
    """Return vehicle j as it was `tau` [s] ago."""
    one, unit, slot = room.numbers, room.unit, now.slot
    late = tau / one.step
    whole = int(late)
    old = late - whole
    new = 1.0 - old
    a = slot - whole if slot >= whole else slot - whole + ring.shape[0]
    b = a - 1 if a > 0 else ring.shape[0] - 1
    kept = one.carried * tau
    slope_x, slope_y = one.bend_x, one.bend_y
    if one.wander != 0.0:
        slope_x += one.wander * unit[now.tick, j, WANDER_X]
        slope_y += one.wander * unit[now.tick, j, WANDER_Y]
    return JetSource(
        new * ring[a, j, X] + old * ring[b, j, X],
        new * ring[a, j, Y] + old * ring[b, j, Y],
        new * ring[a, j, Z] + old * ring[b, j, Z],
        new * ring[a, j, SHARE] + old * ring[b, j, SHARE],
        kept * (new * ring[a, j, SPEED_X] + old * ring[b, j, SPEED_X]),
        kept * (new * ring[a, j, SPEED_Y] + old * ring[b, j, SPEED_Y]),
        slope_x - one.slope * (new * ring[a, j, SLOPE_X] + old * ring[b, j, SLOPE_X]),
        slope_y - one.slope * (new * ring[a, j, SLOPE_Y] + old * ring[b, j, SLOPE_Y]),
    )


@compiled(**BORROWING)
def meet(place: Three, source: JetSource, room: RoomLaw, k: int) -> bool:
    """Write a vehicle's place in a jet into room.under[k]; return whether it is in the jet."""
    one, table, under, ends = room.numbers, room.table, room.under, room.table.ends
    dz = source.z - place[Z]
    down = max(dz, 0.0)
    away_x = place[X] - source.x - source.drift_x - down * source.slope_x
    away_y = place[Y] - source.y - source.drift_y - down * source.slope_y
    spread = max(dz / one.last_gap, 1.0)  # of the self-similar jet below the table
    radius = math.sqrt(away_x * away_x + away_y * away_y)
    gap = abs(dz) / spread
    a = cell(table.gaps, gap)
    if radius >= spread * ends[a]:
        return False
    along = min(max(0.5 * (dz / BLEND + 1.0), 0.0), 1.0)
    under[k, FALL], under[k, RADIUS] = dz, radius / spread
    under[k, AWAY_X], under[k, AWAY_Y] = away_x / max(radius, TOUCHING), away_y / max(radius, TOUCHING)
    under[k, PUSH] = table_push(table, a, gap, radius / spread)
    under[k, WEIGHT] = along * along * (3.0 - 2.0 * along) / (spread * spread)
    under[k, STRENGTH] = under[k, WEIGHT] * source.share
    return True


@compiled(**BORROWING)
def collect(ring: Array, rows: Rows, room: RoomLaw, a: int, now: Now) -> int:
    """Write the vehicles in the jet of the a-th vehicle along x into room.under; return their number."""
    places, met, n, one = room.places, room.met, rows.shape[0] - 1, room.numbers
    x, y, z = places[X, a], places[Y, a], places[Z, a]
    first, count, square = a, 0, now.across * now.across
    while first > 0 and x - places[X, first - 1] <= now.across:
        first -= 1
    for b in range(first, n):
        dx, dy, gap = places[X, b] - x, places[Y, b] - y, z - places[Z, b]
        if dx > now.across:
            break
        beside = dx * dx + dy * dy
        if b == a or gap <= -BLEND or beside > square or beside > reach(now.reach, abs(gap)) ** 2:
            continue
        tau = min(max(gap, 0.0) / one.travel_speed, MAX_DELAY)
        source = past_source(ring, now, room, rows[a], tau)
        if meet((places[X, b], places[Y, b], places[Z, b]), source, room, count):
            met[count] = rows[b]
            count += 1
    return count


@compiled(**BORROWING)
def leave(under: Array, count: int, one: RoomNumbers) -> None:
    """Write the share of a jet that each vehicle in it leaves to those below."""
    for k in range(count):
        aside = under[k, RADIUS] / one.absorbing_width
        taken = max(one.absorbed * math.exp(-0.5 * aside * aside), under[k, PUSH] / GRAVITY)
        under[k, LEFT] = 1.0 - min(under[k, WEIGHT] * taken, 1.0)


@compiled(**BORROWING)
def edge_torque(under: Array, k: int, strength: float, one: RoomNumbers) -> tuple[float, float]:
    """Return the edge torque of a jet about world x and y [N m]."""
    ratio = under[k, RADIUS] / one.torque_radius
    torque = one.torque * strength * ratio * math.exp(0.5 * (1.0 - ratio * ratio))
    return torque * under[k, AWAY_Y], -torque * under[k, AWAY_X]


@compiled(**BORROWING)
def tip(state: Array, i: int, tx: float, ty: float) -> None:
    """Add a torque about world x and y to a vehicle's row, in body axes."""
    x, y, z, w = state[i, QX], state[i, QY], state[i, QZ], state[i, QW]
    state[i, TX] += (1.0 - 2.0 * (y * y + z * z)) * tx + 2.0 * (x * y + w * z) * ty
    state[i, TY] += 2.0 * (x * y - w * z) * tx + (1.0 - 2.0 * (x * x + z * z)) * ty
    state[i, TZ] += 2.0 * (x * z + w * y) * tx + 2.0 * (y * z - w * x) * ty


@compiled(**BORROWING)
def shed(state: Array, room: RoomLaw, j: int, count: int) -> None:
    """Add the jet of vehicle j to the `count` vehicles in it."""
    one, under, met = room.numbers, room.under, room.met
    absorbing = count > 1 and one.absorbed > 0.0
    if absorbing:
        leave(under, count, one)
    for k in range(count):
        strength = under[k, STRENGTH]
        if absorbing:
            for between in range(count):
                if under[between, FALL] < under[k, FALL]:
                    strength *= under[between, LEFT]
        i, push = met[k], strength * room.gains[met[k]] * under[k, PUSH]
        state[i, ETA] -= push
        state[j, ETA] += one.upper_ratio * push
        if one.torque != 0.0:
            tx, ty = edge_torque(under, k, strength, one)
            tip(state, i, tx, ty)


@compiled(**BORROWING)
def drag(state: Array, i: int, per_s: float) -> None:
    """Add the drag of the rotors to the push on a vehicle: against its velocity across its thrust."""
    x, y, z, w = state[i, QX], state[i, QY], state[i, QZ], state[i, QW]
    bx, by, bz = 2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)
    vx, vy, vz = state[i, VX], state[i, VY], state[i, VZ]
    along = vx * bx + vy * by + vz * bz
    state[i, ETA_X] -= per_s * (vx - along * bx)
    state[i, ETA_Y] -= per_s * (vy - along * by)
    state[i, ETA] -= per_s * (vz - along * bz)


@compiled(**BORROWING)
def load(state: Array, i: int, one: RoomNumbers) -> None:
    """Take the load of a vehicle's rotors from their ceilings, ahead by the lag of thrust."""
    rotors = state[i, F1], state[i, F2], state[i, F3], state[i, F4]
    tx, ty, _ = rotor_torque(rotors, one.lever, 0.0)
    roll = one.rate_load * (state[i, P] + one.roll_lead * (tx + state[i, TX]))
    pitch = one.rate_load * (state[i, Q] + one.pitch_lead * (ty + state[i, TY]))
    state[i, CEILING1] += roll + pitch
    state[i, CEILING2] += roll - pitch
    state[i, CEILING3] -= roll + pitch
    state[i, CEILING4] -= roll - pitch


@compiled(**BORROWING)
def surround(state: Array, i: int, unit: float, one: RoomNumbers, mass: float) -> None:
    """Add residual, ground effect and drag to the push on a vehicle; take the load of its rotors off."""
    eta = abs(state[i, ETA])
    state[i, ETA] += (one.floor * min(eta / INSIDE, 1.0) + one.growth * eta) * unit
    near = one.rotor_radius / max(state[i, Z], one.rotor_radius)
    lift = one.ground * near * near * (state[i, F1] + state[i, F2] + state[i, F3] + state[i, F4]) / mass
    x, y, z, w = state[i, QX], state[i, QY], state[i, QZ], state[i, QW]
    state[i, ETA_X] = lift * 2.0 * (x * z + w * y)
    state[i, ETA_Y] = lift * 2.0 * (y * z - w * x)
    state[i, ETA] += lift * (1.0 - 2.0 * (x * x + y * y))
    if one.drag != 0.0:
        drag(state, i, one.drag)
    if one.rate_load != 0.0:
        load(state, i, one)


@compiled(**BORROWING)
def clear(state: Array, ceilings: Array, faded: float) -> None:
    """Write no push, no torque and the largest thrust of each rotor, less what faded, into every state."""
    for i in range(state.shape[0]):
        for column in range(ETA, CEILING1):
            state[i, column] = 0.0
        for rotor in range(4):
            state[i, CEILING1 + rotor] = max(ceilings[i, rotor] - faded, 0.0)


@compiled(**BORROWING)
def add_jets(state: Array, ring: Array, rows: Rows, room: RoomLaw) -> None:
    """Add the jets of all vehicles."""
    n, places, extremes = state.shape[0], room.places, room.extremes
    watch(state, ring, rows, extremes)
    sort_by_x(state, rows)
    lowest, highest = state[0, Z], state[0, Z]
    for a in range(n):
        i = rows[a]
        places[X, a], places[Y, a], places[Z, a] = state[i, X], state[i, Y], state[i, Z]
        lowest, highest = min(lowest, state[i, Z]), max(highest, state[i, Z])
    to = reach_of(room.bound, extremes)
    across = reach(to, max(highest - lowest, BLEND))
    now = Now(rows[n] % ring.shape[0], rows[n] % room.unit.shape[0], across, to)
    for a in range(n):
        count = collect(ring, rows, room, a, now)
        if count:
            shed(state, room, rows[a], count)


@compiled(**BORROWING)
def room_push(state: Array, ring: Array, rows: Rows, room: RoomLaw, mass: float) -> None:
    """Write push, torque and largest rotor thrust of every vehicle; `mass` in [kg]."""
    n, one, unit = state.shape[0], room.numbers, room.unit
    clear(state, room.ceilings, one.fading * one.step * float(rows[n]))
    if n > 1 and room.bound.near > 0.0:
        add_jets(state, ring, rows, room)
    tick = rows[n] % unit.shape[0]
    for i in range(n):
        surround(state, i, unit[tick, i, RESIDUAL], one, mass)
