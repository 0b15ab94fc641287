"""Air of a room as compiled code takes it: table of the jet, numbers of all terms, room to work in.

Pairs are visited within a bound of the jet's reach. It ends within near + spread gap, or widening gap below
the table, where its source has sunk by at most FASTEST since its air left; its axis is no farther from its
source than (tilt s + drift) gap + turn gap^2, with the largest slope s of any source on the way.
"""

import math
from typing import NamedTuple

import numpy as np

from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import GRAVITY
from q2q_sim.air.room_air import JetTerm, RoomAir, ends_of_jet
from q2q_sim.air.unit_processes import WIDTH, block_steps
from q2q_sim.air.wake_laws import FASTEST
from q2q_sim.plant.quadcopter import Body

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
    near: float
    """[m]; 0 if there is no jet."""
    spread: float
    widening: float
    """[m/m]"""
    tilt: float
    """[-]"""
    drift: float
    """[-]"""
    turn: float
    """[1/m]"""
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
    ends: Array
    """Radius within which a vehicle is in the jet [m], (a - 1,)."""


class RoomLaw(NamedTuple):
    """Air of a room in compiled code."""

    table: PushTable
    unit: Array
    """Block of the unit processes, (steps, n, WIDTH)."""
    under: Array
    """Room for the vehicles in one jet, (n, UNDER_WIDTH)."""
    source: Array
    """Room for the source of that jet, (PAST_WIDTH,)."""
    steepest: Array
    """Squares of the largest slopes of vehicles in this period and the last, and its number, (3,)."""
    numbers: RoomNumbers


def room_law(air: RoomAir, count: int, body: Body) -> RoomLaw:
    """Return the compiled form of an air for `count` vehicles."""
    jet = air.jet or NO_JET
    return RoomLaw(
        table=PushTable(*map(np.ascontiguousarray, (jet.gaps_m, jet.radii_m, jet.push_mps2, _ends(air)))),
        unit=np.zeros((block_steps(body.step), count, WIDTH)),
        under=np.zeros((count, UNDER_WIDTH)),
        source=np.zeros(PAST_WIDTH),
        steepest=np.zeros(3),
        numbers=_numbers(air, body),
    )


def _numbers(air: RoomAir, body: Body) -> RoomNumbers:
    jet, absorption, residual = air.jet or NO_JET, air.absorption, air.residual
    torque, ground, own = air.edge_torque, air.ground, air.vehicle
    gaps, ends = jet.gaps_m, _ends(air)
    rise = 1.0 + FASTEST / jet.travel_speed_mps
    lean = math.hypot(*jet.bend) + FARTHEST * (air.meander.std if air.meander else 0.0)
    hover = 0.25 * body.mass * GRAVITY  # thrust of a rotor
    return RoomNumbers(
        step=body.step,
        last_gap=float(jet.gaps_m[-1]),
        near=float(ends[0]),
        spread=rise * max(0.0, *((ends[1:] - ends[0]) / gaps[1:-1])) if len(ends) > 1 else 0.0,
        widening=rise * float(ends[-1] / gaps[-1]),
        tilt=rise * abs(jet.slope),
        drift=abs(1.0 - jet.carried) * FASTEST / jet.travel_speed_mps + rise * lean,
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


def _ends(air: RoomAir) -> Array:
    return ends_of_jet(air.jet, air.absorption) if air.jet else np.zeros(1)
