"""Push and torque of a room's air on every vehicle, compiled: the equations of q2q_sim.air.room_air.

For each source, the vehicles in its jet are collected from the vehicles sorted by x, and the jet acts on each
with what those between have not absorbed. Then each vehicle feels the residual and the ground.
"""

import math
from functools import partial
from typing import NamedTuple

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import GRAVITY
from q2q_sim.air.room_air import INSIDE, JetTerm, MeanderTerm, RoomAir
from q2q_sim.air.unit_processes import RESIDUAL, WANDER_X, WANDER_Y, WIDTH, block_steps
from q2q_sim.air.wake_laws import BLEND, FASTEST, MAX_DELAY
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
    Body,
    X,
    Y,
    Z,
)

SPEED_X, SPEED_Y, SLOPE_X, SLOPE_Y = 4, 5, 6, 7
"""Columns of a slot of the ring after those of law_push: velocity [m/s], slope of the body z axis."""
PAST_WIDTH = 8
STEEPEST = 0.6
"""Largest slope of a jet [-]: 31 degrees."""
HARDEST = 10.0
"""Largest acceleration of a source whose past position is searched [m/s^2]."""
FARTHEST = 5.0
"""Largest value of a unit process that is searched [-]."""
NO_JET = JetTerm(np.array([0.0, 1.0]), np.array([0.0, 1.0]), np.zeros((2, 2)), 0.0, 1.0, 0.0, 0.0)
TOUCHING = 1e-9
"""Distance from the axis below which its direction is taken as zero [m]."""

ROW, FALL, RADIUS, AWAY_X, AWAY_Y, PUSH, WEIGHT, STRENGTH = 0, 1, 2, 3, 4, 5, 6, 7
"""Columns of a vehicle in a jet: its row, dz and r g / dz [m], direction from the axis to it, P [m/s^2] of a
source that carries its weight, blend of the roles times (g / dz)^2, and that times T / (m g)."""
UNDER_WIDTH = 8


class RoomNumbers(NamedTuple):
    """Parameters of a RoomAir; a term that is off has zeros."""

    step: float
    """[s]"""
    last_gap: float
    """Of the table [m]."""
    radius: float
    """Last of the table [m]; 0 if there is no jet."""
    widening: float
    """Growth of the radius with the gap below the table [m/m]."""
    drift: float
    turn: float
    """A jet's axis is no farther from its source than drift gap + turn gap^2 [-], [1/m]."""
    upper_ratio: float
    travel_speed: float
    carried: float
    slope: float
    bend_x: float
    bend_y: float
    wander: float
    absorbed: float
    absorbing_width: float
    floor: float
    growth: float
    torque: float
    torque_radius: float
    ground: float
    rotor_radius: float
    full_thrust: float
    """Largest thrust of a rotor with a full battery [N]; infinite if there is no vehicle term."""
    fading: float
    """Its loss [N/s]."""


class PushTable(NamedTuple):
    """Table of P."""

    gaps: Array
    """[m], (a,)."""
    radii: Array
    """[m], (b,)."""
    push: Array
    """[m/s^2], (a, b)."""


class RoomLaw(NamedTuple):
    """Air of a room in compiled code."""

    table: PushTable
    unit: Array
    """Block of the unit processes, (steps, n, WIDTH)."""
    under: Array
    """Room for the vehicles in one jet, (n, UNDER_WIDTH)."""
    source: Array
    """Room for the source of that jet, (PAST_WIDTH,)."""
    numbers: RoomNumbers


class Past(NamedTuple):
    """Past states of the vehicles."""

    ring: Array
    """(slots, n, PAST_WIDTH)."""
    rows: Rows
    """Rows by rising x, then the number of steps taken, (n + 1,)."""


def room_law(air: RoomAir, count: int, body: Body) -> RoomLaw:
    """Return the compiled form of an air for `count` vehicles."""
    jet = air.jet or NO_JET
    return RoomLaw(
        table=PushTable(*(np.ascontiguousarray(one) for one in (jet.gaps_m, jet.radii_m, jet.push_mps2))),
        unit=np.zeros((block_steps(body.step), count, WIDTH)),
        under=np.zeros((count, UNDER_WIDTH)),
        source=np.zeros(PAST_WIDTH),
        numbers=_numbers(air, body),
    )


def _numbers(air: RoomAir, body: Body) -> RoomNumbers:
    jet, absorption, residual = air.jet or NO_JET, air.absorption, air.residual
    torque, ground, own = air.edge_torque, air.ground, air.vehicle
    radius = float(jet.radii_m[-1]) if air.jet else 0.0
    hover = 0.25 * body.mass * GRAVITY  # thrust of a rotor
    return RoomNumbers(
        step=body.step,
        last_gap=float(jet.gaps_m[-1]),
        radius=radius,
        widening=radius / float(jet.gaps_m[-1]),
        drift=_drift(jet, air.meander),
        turn=0.5 * abs(jet.carried) * HARDEST / jet.travel_speed_mps**2,
        upper_ratio=jet.upper_ratio,
        travel_speed=jet.travel_speed_mps,
        carried=jet.carried,
        slope=jet.slope,
        bend_x=jet.bend[0],
        bend_y=jet.bend[1],
        wander=air.meander.std if air.meander else 0.0,
        absorbed=absorption.share if absorption else 0.0,
        absorbing_width=absorption.width_m if absorption else 1.0,
        floor=residual.floor_mps2 if residual else 0.0,
        growth=residual.slope if residual else 0.0,
        torque=torque.peak_nm if torque else 0.0,
        torque_radius=torque.radius_m if torque else 1.0,
        ground=ground.coefficient if ground else 0.0,
        rotor_radius=ground.rotor_radius_m if ground else 1.0,
        full_thrust=hover * own.headroom if own else math.inf,
        fading=hover * own.headroom_per_volt * own.discharge_v_per_s if own else 0.0,
    )


def _drift(jet: JetTerm, meander: MeanderTerm | None) -> float:
    """Return the bound `drift` of the distance between a jet's axis and its source [-]."""
    lean = STEEPEST * abs(jet.slope) + math.hypot(*jet.bend) + FARTHEST * (meander.std if meander else 0.0)
    return abs(1.0 - jet.carried) * FASTEST / jet.travel_speed_mps + lean


def _cell(knots: Array, value: float) -> int:
    """Return the last cell whose lower end is at most `value`."""
    k = 0
    while k < knots.shape[0] - 2 and value > knots[k + 1]:
        k += 1
    return k


def _table_push(table: PushTable, gap: float, radius: float) -> float:
    """Return P [m/s^2] within the table's gaps and radii."""
    gaps, radii, push = table
    a, b = cell(gaps, gap), cell(radii, radius)
    along = min(max((gap - gaps[a]) / (gaps[a + 1] - gaps[a]), 0.0), 1.0)
    aside = max((radius - radii[b]) / (radii[b + 1] - radii[b]), 0.0)
    near = (1.0 - aside) * push[a, b] + aside * push[a, b + 1]
    far = (1.0 - aside) * push[a + 1, b] + aside * push[a + 1, b + 1]
    return float((1.0 - along) * near + along * far)


def _source(past: Past, room: RoomLaw, j: int, late: float) -> None:
    """Write vehicle j as it was `late` steps ago into room.source, with the slope of its jet for its own."""
    one, source, ring = room.numbers, room.source, past.ring
    slots, now = ring.shape[0], past.rows[past.rows.shape[0] - 1]
    whole = math.floor(late)
    share = late - whole
    newer, older = (now - whole) % slots, (now - whole - 1) % slots
    for column in range(PAST_WIDTH):
        source[column] = (1.0 - share) * ring[newer, j, column] + share * ring[older, j, column]
    unit = room.unit[now % room.unit.shape[0], j]
    source[SLOPE_X] = one.bend_x + one.wander * unit[WANDER_X] - one.slope * source[SLOPE_X]
    source[SLOPE_Y] = one.bend_y + one.wander * unit[WANDER_Y] - one.slope * source[SLOPE_Y]


def _meet(row: Array, room: RoomLaw, tau: float, under: Array) -> bool:
    """Write the vehicle's place in the jet of room.source into a row of `under`; return if it has one."""
    one, source = room.numbers, room.source
    dz = source[Z] - row[Z]
    down, kept = max(dz, 0.0), one.carried * tau
    away_x = row[X] - source[X] - kept * source[SPEED_X] - down * source[SLOPE_X]
    away_y = row[Y] - source[Y] - kept * source[SPEED_Y] - down * source[SLOPE_Y]
    spread = max(dz / one.last_gap, 1.0)  # of the self-similar jet below the table
    radius = math.sqrt(away_x * away_x + away_y * away_y)
    if radius >= spread * one.radius:
        return False
    along = min(max(0.5 * (dz / BLEND + 1.0), 0.0), 1.0)
    under[FALL], under[RADIUS] = dz, radius / spread
    under[AWAY_X], under[AWAY_Y] = away_x / max(radius, TOUCHING), away_y / max(radius, TOUCHING)
    under[PUSH] = table_push(room.table, abs(dz) / spread, radius / spread)
    under[WEIGHT] = along * along * (3.0 - 2.0 * along) / (spread * spread)
    under[STRENGTH] = under[WEIGHT] * source[SHARE]
    return True


def _absorbed(under: Array, one: RoomNumbers) -> float:
    """Return the share c of a jet that a vehicle in it absorbs."""
    if one.absorbed == 0.0:
        return 0.0
    aside = under[RADIUS] / one.absorbing_width
    taken = max(one.absorbed * math.exp(-0.5 * aside * aside), under[PUSH] / GRAVITY)
    return float(min(under[WEIGHT] * taken, 1.0))


def _tip(row: Array, under: Array, strength: float, one: RoomNumbers) -> None:
    """Add the edge torque of a jet to a vehicle's row, in body axes."""
    ratio = under[RADIUS] / one.torque_radius
    torque = one.torque * strength * ratio * math.exp(0.5 * (1.0 - ratio * ratio))
    tx, ty = torque * under[AWAY_Y], -torque * under[AWAY_X]  # world
    x, y, z, w = row[QX], row[QY], row[QZ], row[QW]
    row[TX] += (1.0 - 2.0 * (y * y + z * z)) * tx + 2.0 * (x * y + w * z) * ty
    row[TY] += 2.0 * (x * y - w * z) * tx + (1.0 - 2.0 * (x * x + z * z)) * ty
    row[TZ] += 2.0 * (x * z + w * y) * tx + 2.0 * (y * z - w * x) * ty


def _collect(state: Array, past: Past, room: RoomLaw, a: int, bound: float) -> int:
    """Write the vehicles in the jet of the a-th vehicle along x into room.under; return their number."""
    n, one, rows = state.shape[0], room.numbers, past.rows
    j, count = rows[a], 0
    for side in (-1, 1):
        b = a + side
        while 0 <= b < n and abs(state[rows[b], X] - state[j, X]) <= bound:
            i = rows[b]
            dx, dy, gap = state[j, X] - state[i, X], state[j, Y] - state[i, Y], state[j, Z] - state[i, Z]
            reach = max(one.radius, one.widening * gap) + (one.drift + one.turn * abs(gap)) * abs(gap)
            b += side
            if gap <= -BLEND or dx * dx + dy * dy > reach * reach:
                continue
            tau = min(max(gap, 0.0) / one.travel_speed, MAX_DELAY)
            source(past, room, j, tau / one.step)
            if meet(state[i], room, tau, room.under[count]):
                room.under[count, ROW] = i
                count += 1
    return count


def _shed(state: Array, past: Past, room: RoomLaw, a: int, bound: float) -> None:
    """Add the jet of the a-th vehicle along x to those in it."""
    one, under = room.numbers, room.under
    count = collect(state, past, room, a, bound)
    for k in range(count):
        strength = under[k, STRENGTH]
        for between in range(count):
            if under[between, FALL] < under[k, FALL]:
                strength *= 1.0 - absorbed(under[between], one)
        i, push = int(under[k, ROW]), strength * under[k, PUSH]
        state[i, ETA] -= push
        state[past.rows[a], ETA] += one.upper_ratio * push
        if one.torque != 0.0:
            tip(state[i], under[k], strength, one)


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


def _room_push(state: Array, ring: Array, rows: Rows, room: RoomLaw, mass: float) -> None:
    n, one, past = state.shape[0], room.numbers, Past(ring, rows)
    lowest, highest = state[0, Z], state[0, Z]
    ceiling = max(one.full_thrust - one.fading * one.step * float(rows[n]), 0.0)
    for i in range(n):
        for column in (ETA, ETA_X, ETA_Y, TX, TY, TZ):
            state[i, column] = 0.0
        state[i, CEILING] = ceiling
        lowest, highest = min(lowest, state[i, Z]), max(highest, state[i, Z])
    if n > 1 and one.radius > 0.0:
        sort_by_x(state, rows)
        gap = highest - lowest
        bound = max(one.radius, one.widening * gap) + (one.drift + one.turn * gap) * gap
        for a in range(n):
            shed(state, past, room, a, bound)
    for i in range(n):
        surround(state[i], room.unit[rows[n] % room.unit.shape[0], i, RESIDUAL], one, mass)


part = partial(compiled, inline="always")
cell, table_push, source, meet = part(_cell), part(_table_push), part(_source), part(_meet)
absorbed, tip, collect, shed = part(_absorbed), part(_tip), part(_collect), part(_shed)
surround = part(_surround)
room_push = compiled(_room_push)
"""Write push, torque and largest rotor thrust of every vehicle: (state, ring, rows, RoomLaw, mass [kg])."""
