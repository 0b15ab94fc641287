"""Push and torque of a room's air on every vehicle, compiled: the equations of q2q_sim.air.room_air.

For each source, the vehicles in its jet are collected from the vehicles sorted by x, and the jet acts on each
with what those between have not absorbed. Then each vehicle feels the residual and the ground.
"""

import math
from typing import NamedTuple

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import GRAVITY
from q2q_sim.air.room_air import INSIDE
from q2q_sim.air.unit_processes import RESIDUAL, WANDER_X, WANDER_Y
from q2q_sim.air.wake_laws import BLEND, MAX_DELAY
from q2q_sim.plant.law_push import SHARE
from q2q_sim.plant.order_by_x import Rows, sort_by_x
from q2q_sim.plant.quadcopter import (
    CEILING,
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
    X,
    Y,
    Z,
)
from q2q_sim.plant.room_law import (
    AWAY_X,
    AWAY_Y,
    FALL,
    PAST_WIDTH,
    PUSH,
    RADIUS,
    ROW,
    SLOPE_X,
    SLOPE_Y,
    SPEED_X,
    SPEED_Y,
    STRENGTH,
    WEIGHT,
    PushTable,
    RoomLaw,
    RoomNumbers,
)

TOUCHING = 1e-9
"""Distance from the axis below which its direction is taken as zero [m]."""


class Past(NamedTuple):
    """Past states of the vehicles."""

    ring: Array
    """(slots, n, PAST_WIDTH)."""
    rows: Rows
    """Rows by rising x, then the number of steps taken, (n + 1,)."""


class Now(NamedTuple):
    """Present step, and bound of the search for the vehicles in a jet."""

    slot: int
    """Of the ring."""
    tick: int
    """Of the block of unit processes."""
    drift: float
    """Slope between axis and source [-]."""
    across: float
    """Distance at the largest gap [m]."""


@compiled(inline="always")
def _cell(knots: Array, value: float) -> int:
    """Return the last cell whose lower end is below `value`, from where evenly spaced knots would have it."""
    last = knots.shape[0] - 2
    k: int = min(int(value / knots[last + 1] * last), last)
    while k > 0 and value <= knots[k]:
        k -= 1
    while k < last and value > knots[k + 1]:
        k += 1
    return k


@compiled(inline="always")
def _table_push(table: PushTable, a: int, gap: float, radius: float) -> float:
    """Return P [m/s^2] at a gap in the table's cell a."""
    gaps, radii, push, _ = table
    b = _cell(radii, radius)
    along = min(max((gap - gaps[a]) / (gaps[a + 1] - gaps[a]), 0.0), 1.0)
    aside = max((radius - radii[b]) / (radii[b + 1] - radii[b]), 0.0)
    near = (1.0 - aside) * push[a, b] + aside * push[a, b + 1]
    far = (1.0 - aside) * push[a + 1, b] + aside * push[a + 1, b + 1]
    return float((1.0 - along) * near + along * far)


@compiled(inline="always")
def _source(ring: Array, now: Now, room: RoomLaw, j: int, late: float) -> None:
    """Write vehicle j as it was `late` steps ago into room.source, with the slope of its jet for its own."""
    one, source = room.numbers, room.source
    whole = int(late)
    share = late - whole
    newer = now.slot - whole
    newer += ring.shape[0] if newer < 0 else 0
    older = newer - 1 if newer > 0 else ring.shape[0] - 1
    for column in range(PAST_WIDTH):
        source[column] = (1.0 - share) * ring[newer, j, column] + share * ring[older, j, column]
    wander_x, wander_y = room.unit[now.tick, j, WANDER_X], room.unit[now.tick, j, WANDER_Y]
    source[SLOPE_X] = one.bend_x + one.wander * wander_x - one.slope * source[SLOPE_X]
    source[SLOPE_Y] = one.bend_y + one.wander * wander_y - one.slope * source[SLOPE_Y]


@compiled(inline="always")
def _meet(row: Array, room: RoomLaw, tau: float, under: Array) -> bool:
    """Write the vehicle's place in the jet of room.source into a row of `under`; return if it has one."""
    one, source = room.numbers, room.source
    dz = source[Z] - row[Z]
    down, kept = max(dz, 0.0), one.carried * tau
    away_x = row[X] - source[X] - kept * source[SPEED_X] - down * source[SLOPE_X]
    away_y = row[Y] - source[Y] - kept * source[SPEED_Y] - down * source[SLOPE_Y]
    spread = max(dz / one.last_gap, 1.0)  # of the self-similar jet below the table
    radius = math.sqrt(away_x * away_x + away_y * away_y)
    gap = abs(dz) / spread
    a = _cell(room.table.gaps, gap)
    if radius >= spread * room.table.ends[a]:
        return False
    along = min(max(0.5 * (dz / BLEND + 1.0), 0.0), 1.0)
    under[FALL], under[RADIUS] = dz, radius / spread
    under[AWAY_X], under[AWAY_Y] = away_x / max(radius, TOUCHING), away_y / max(radius, TOUCHING)
    under[PUSH] = _table_push(room.table, a, gap, radius / spread)
    under[WEIGHT] = along * along * (3.0 - 2.0 * along) / (spread * spread)
    under[STRENGTH] = under[WEIGHT] * source[SHARE]
    return True


@compiled(inline="always")
def _absorbed(under: Array, one: RoomNumbers) -> float:
    """Return the share c of a jet that a vehicle in it absorbs."""
    if one.absorbed == 0.0:
        return 0.0
    aside = under[RADIUS] / one.absorbing_width
    taken = max(one.absorbed * math.exp(-0.5 * aside * aside), under[PUSH] / GRAVITY)
    return float(min(under[WEIGHT] * taken, 1.0))


@compiled(inline="always")
def _tip(row: Array, under: Array, strength: float, one: RoomNumbers) -> None:
    """Add the edge torque of a jet to a vehicle's row, in body axes."""
    ratio = under[RADIUS] / one.torque_radius
    torque = one.torque * strength * ratio * math.exp(0.5 * (1.0 - ratio * ratio))
    tx, ty = torque * under[AWAY_Y], -torque * under[AWAY_X]  # world
    x, y, z, w = row[QX], row[QY], row[QZ], row[QW]
    row[TX] += (1.0 - 2.0 * (y * y + z * z)) * tx + 2.0 * (x * y + w * z) * ty
    row[TY] += 2.0 * (x * y - w * z) * tx + (1.0 - 2.0 * (x * x + z * z)) * ty
    row[TZ] += 2.0 * (x * z + w * y) * tx + 2.0 * (y * z - w * x) * ty


@compiled(inline="always")
def _drift(past: Past, room: RoomLaw) -> float:
    """Return the largest slope between the axis of a jet and its source now [-], by periods of the ring."""
    one, ring, steepest, steps = room.numbers, past.ring, room.steepest, past.rows[past.rows.shape[0] - 1]
    period = steps // ring.shape[0]
    if period != steepest[2]:
        steepest[0], steepest[1], steepest[2] = 0.0, steepest[0], period
    now = ring[steps % ring.shape[0]]
    for i in range(now.shape[0]):
        steepest[0] = max(steepest[0], now[i, SLOPE_X] ** 2 + now[i, SLOPE_Y] ** 2)
    return one.tilt * math.sqrt(max(steepest[0], steepest[1])) + one.drift


@compiled(inline="always")
def _reach(one: RoomNumbers, drift: float, gap: float) -> float:
    """Return the largest distance of a vehicle in a jet from its source [m]."""
    return max(one.near + one.spread * gap, one.widening * gap) + (drift + one.turn * gap) * gap


@compiled(inline="always")
def _collect(state: Array, past: Past, room: RoomLaw, a: int, now: Now) -> int:
    """Write the vehicles in the jet of the a-th vehicle along x into room.under; return their number."""
    n, one, rows = state.shape[0], room.numbers, past.rows
    j, count = rows[a], 0
    for side in (-1, 1):
        b = a + side
        while 0 <= b < n and abs(state[rows[b], X] - state[j, X]) <= now.across:
            i = rows[b]
            dx, dy, gap = state[j, X] - state[i, X], state[j, Y] - state[i, Y], state[j, Z] - state[i, Z]
            b += side
            if gap <= -BLEND or dx * dx + dy * dy > _reach(one, now.drift, abs(gap)) ** 2:
                continue
            tau = min(max(gap, 0.0) / one.travel_speed, MAX_DELAY)
            _source(past.ring, now, room, j, tau / one.step)
            if _meet(state[i], room, tau, room.under[count]):
                room.under[count, ROW] = i
                count += 1
    return count


@compiled(inline="always")
def _shed(state: Array, past: Past, room: RoomLaw, a: int, now: Now) -> None:
    """Add the jet of the a-th vehicle along x to those in it."""
    one, under = room.numbers, room.under
    count = _collect(state, past, room, a, now)
    for k in range(count):
        strength = under[k, STRENGTH]
        for between in range(count):
            if under[between, FALL] < under[k, FALL]:
                strength *= 1.0 - _absorbed(under[between], one)
        i, push = int(under[k, ROW]), strength * under[k, PUSH]
        state[i, ETA] -= push
        state[past.rows[a], ETA] += one.upper_ratio * push
        if one.torque != 0.0:
            _tip(state[i], under[k], strength, one)


@compiled(inline="always")
def _surround(row: Array, unit: float, one: RoomNumbers, mass: float) -> None:
    """Add the residual and the ground effect to the push on a vehicle."""
    eta = abs(row[ETA])
    row[ETA] += (one.floor * min(eta / INSIDE, 1.0) + one.growth * eta) * unit
    near = one.rotor_radius / max(row[Z], one.rotor_radius)
    lift = one.ground * near * near * (row[F1] + row[F2] + row[F3] + row[F4]) / mass
    x, y, z, w = row[QX], row[QY], row[QZ], row[QW]
    row[ETA_X] += lift * 2.0 * (x * z + w * y)
    row[ETA_Y] += lift * 2.0 * (y * z - w * x)
    row[ETA] += lift * (1.0 - 2.0 * (x * x + y * y))


@compiled
def room_push(state: Array, ring: Array, rows: Rows, room: RoomLaw, mass: float) -> None:
    """Write push, torque and largest rotor thrust of every vehicle; `mass` in [kg]."""
    n, one, past = state.shape[0], room.numbers, Past(ring, rows)
    lowest, highest = state[0, Z], state[0, Z]
    tick = rows[n] % room.unit.shape[0]
    ceiling = max(one.full_thrust - one.fading * one.step * float(rows[n]), 0.0)
    for i in range(n):
        for column in (ETA, ETA_X, ETA_Y, TX, TY, TZ):
            state[i, column] = 0.0
        state[i, CEILING] = ceiling
        lowest, highest = min(lowest, state[i, Z]), max(highest, state[i, Z])
    if n > 1 and one.near > 0.0:
        sort_by_x(state, rows)
        lean = _drift(past, room)
        now = Now(rows[n] % ring.shape[0], tick, lean, _reach(one, lean, max(highest - lowest, BLEND)))
        for a in range(n):
            _shed(state, past, room, a, now)
    for i in range(n):
        _surround(state[i], room.unit[tick, i, RESIDUAL], one, mass)
