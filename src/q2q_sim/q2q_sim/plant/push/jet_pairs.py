"""Pairs of a vehicle in a jet and its source, compiled: who is in whose jet, and where in it.

Of the vehicles in reach of a source, those are kept that are within the jet, whose axis begins where the
source was when the air left it. The equations are those of q2q_sim.air.room_air.
"""

import math
from typing import NamedTuple

from q2q_model.compiled import HOT, compiled
from q2q_model.signals.values import Array, Rows, Three
from q2q_sim.air.unit_processes import MEANDER_X, MEANDER_Y
from q2q_sim.air.wake_laws import BLEND, MAX_DELAY
from q2q_sim.plant.body.state_row import X, Y, Z
from q2q_sim.plant.push.compiled_room_air import (
    AWAY_X,
    AWAY_Y,
    FALL,
    PAST,
    PUSH,
    RADIUS,
    STRENGTH,
    TAU,
    WEIGHT,
    CompiledRoomAir,
)
from q2q_sim.plant.push.jet_reach import JetReach, reach
from q2q_sim.plant.push.push_table import cell, table_push
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
    """Return the way from the jet's axis to the vehicle of the k-th pair along x and y, and its fall [m].

    `tick` is that of Now.
    """
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
    """Write what the k-th vehicle is for the jet into jet_rows[kept]; return whether it is in the jet."""
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
    """Add the vehicles in reach of vehicle j to the `count` pairs; return their number.

    `found` are rows by rising x, those of the neighbour list or of all vehicles.
    """
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
    """Keep of the `count` pairs those with a vehicle in the jet; return their number.

    `ring` (slots, n, ROOM_WIDTH) is that of state_history_ring.
    """
    for k in range(count):  # all pasts are read before a branch depends on one
        late = room.jet_rows[k, TAU] / room.numbers.step
        recall(ring, now.slot, room.source[k], late, room.jet_rows[k, PAST:])
    kept = 0
    for k in range(count):
        kept += write_jet_row(room, k, kept, now.tick)
    return kept
