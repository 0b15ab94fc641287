"""Air of a room as compiled code takes it: numbers of all terms, draws of a flight, workspace."""

import math
from typing import NamedTuple

import numpy as np

from q2q_model.signals.values import Array, Rows
from q2q_model.vehicle.constants import GRAVITY
from q2q_sim.air.air_terms import JetTerm
from q2q_sim.air.room_air import RoomAir
from q2q_sim.air.unit_processes import KINDS, block_steps
from q2q_sim.plant.body.quadcopter import Body
from q2q_sim.plant.push.jet_reach import EXTREMES_WIDTH, SearchBound, bound_of
from q2q_sim.plant.push.neighbour_list import NeighbourList, empty_list
from q2q_sim.plant.push.push_table import PushTable, ends_of_jet, knots_of
from q2q_sim.plant.push.state_history_ring import ROOM_WIDTH
from q2q_sim.random_streams import stream

LEAST_WORK = 0.5
"""Minimum work of a motor over the mean of a vehicle's four that is drawn [-]."""
FARTHEST = 5.0
"""Largest value of a unit process that is searched [-]."""
NO_JET = JetTerm(np.array([0.0, 1.0]), np.array([0.0, 1.0]), np.zeros((2, 2)), 0.0, 1.0, 0.0, 0.0)

FALL, RADIUS, AWAY_X, AWAY_Y, PUSH, WEIGHT, STRENGTH, TRANSMITTED = 0, 1, 2, 3, 4, 5, 6, 7
"""Columns of a vehicle in a jet: dz and r g / dz [m], direction from the axis to it, P [m/s^2] of a source
that carries its weight, blend of the roles times (g / dz)^2, that times T / (m g), and the share 1 - c of
the jet that it transmits to those below."""
TAU, PAST = FALL, 8
"""Column of the age of the air [s] until the fall is known, and first of the source's columns of the state
history when its air left."""
JET_ROW_WIDTH = PAST + ROOM_WIDTH
AT_ONCE = 64
"""Pairs whose pasts are read together: enough that waits for memory overlap, few enough for a first cache."""


class RoomNumbers(NamedTuple):
    """Parameters of a RoomAir; a term that is off has zeros."""

    step: float
    """[s]"""
    last_gap: float
    """Of the table [m]."""
    upper_ratio: float
    travel_speed: float
    carried: float
    slope: float
    bend_x: float
    bend_y: float
    meander: float
    absorbed: float
    absorbing_width: float
    floor: float
    growth: float
    torque: float
    torque_radius: float
    ground: float
    rotor_radius: float
    ground_from: float
    """Height from which the ground effect grows no further [m]."""
    fading: float
    """Loss of the largest thrust of a rotor [N/s]."""
    drag: float
    """[1/s]"""
    rate_load: float
    """Load of a rotor over roll or pitch rate [N s]."""
    roll_lead: float
    pitch_lead: float
    """Lag of the thrust over the moment of inertia [s/(kg m^2)]."""
    lever: float
    """Of the rotors [m]."""


class CompiledRoomAir(NamedTuple):
    """Air of a room in compiled code."""

    table: PushTable
    numbers: RoomNumbers
    bound: SearchBound
    """Of the search for the vehicles in a jet."""
    unit: Array
    """Block of the unit processes, (KINDS, steps, n)."""
    extremes: Array
    """Largest slope and speed of the vehicles (q2q_sim.plant.push.jet_reach), (EXTREMES_WIDTH,)."""
    rotor_max: Array
    """Largest thrust of each rotor at the start [N], (n, 4); infinite without a vehicle term."""
    gains: Array
    """Gain of each vehicle on the mean downwash [-], (n,)."""
    near: NeighbourList
    """List of the vehicles near each source."""
    places: Array
    """Workspace for x, y, z [m] of the vehicles, (3, n)."""
    jet_rows: Array
    """Workspace for pairs of a vehicle in a jet and its source, (n + AT_ONCE, JET_ROW_WIDTH)."""
    receiver: Rows
    """Workspace for the vehicles' rows, (n + AT_ONCE,)."""
    source: Rows
    """Workspace for the sources' rows, (n + AT_ONCE,)."""


def compiled_room_air(air: RoomAir, count: int, body: Body, seed: int) -> CompiledRoomAir:
    """Return the compiled form of an air for `count` vehicles of a flight of a seed."""
    jet = air.jet or NO_JET
    ends = ends_of_jet(air.jet, air.absorption) if air.jet else np.zeros(1)
    lean = FARTHEST * air.meander.std if air.meander else 0.0
    return CompiledRoomAir(
        table=PushTable(
            gaps=knots_of(jet.gaps_m),
            radii=knots_of(jet.radii_m),
            push=np.ascontiguousarray(jet.push_mps2),
            ends=np.ascontiguousarray(ends),
        ),
        numbers=_numbers(air, body),
        bound=bound_of(jet, ends, lean),
        unit=np.zeros((KINDS, block_steps(body.step), count)),
        extremes=np.zeros(EXTREMES_WIDTH),
        rotor_max=rotor_max(air, count, body.mass, seed),
        gains=gains(air, count, seed),
        near=empty_list(count),
        places=np.zeros((3, count)),
        jet_rows=np.zeros((count + AT_ONCE, JET_ROW_WIDTH)),
        receiver=np.zeros(count + AT_ONCE, dtype=np.intp),
        source=np.zeros(count + AT_ONCE, dtype=np.intp),
    )


def rotor_max(air: RoomAir, count: int, mass: float, seed: int) -> Array:
    """Return the largest thrust of each rotor of the vehicles [N], (n, 4), drawn for a flight."""
    if air.vehicle is None:
        return np.full((count, 4), math.inf)
    drawn = stream(seed, "vehicle headroom").standard_normal((count, 1))
    headroom = air.vehicle.headroom + air.vehicle.headroom_std * drawn
    apart = stream(seed, "motors").standard_normal((count, 4))
    work = 1.0 + air.vehicle.motor_std * (apart - apart.mean(axis=1, keepdims=True))
    return np.asarray(0.25 * mass * GRAVITY * headroom / np.maximum(work, LEAST_WORK))


def gains(air: RoomAir, count: int, seed: int) -> Array:
    """Return the gain of each vehicle on the mean downwash [-], (n,), drawn for a flight."""
    if air.residual is None:
        return np.ones(count)
    drawn = stream(seed, "wake gain").standard_normal(count)
    return np.asarray(np.maximum(1.0 + air.residual.gain_std * drawn, 0.0))


def _numbers(air: RoomAir, body: Body) -> RoomNumbers:
    jet, absorption, residual = air.jet or NO_JET, air.absorption, air.residual
    torque, ground, own = air.edge_torque, air.ground, air.vehicle
    lever, lag = body.frame[0], own.thrust_lag_s if own else 0.0
    hover = 0.25 * body.mass * GRAVITY  # thrust of a rotor
    return RoomNumbers(
        step=body.step,
        last_gap=float(jet.gaps_m[-1]),
        upper_ratio=jet.upper_ratio,
        travel_speed=jet.travel_speed_mps,
        carried=jet.carried,
        slope=jet.slope,
        bend_x=jet.bend[0],
        bend_y=jet.bend[1],
        meander=air.meander.std if air.meander else 0.0,
        absorbed=absorption.share if absorption else 0.0,
        absorbing_width=absorption.width_m if absorption else 1.0,
        floor=residual.floor_mps2 if residual else 0.0,
        growth=residual.slope if residual else 0.0,
        torque=torque.peak_nm if torque else 0.0,
        torque_radius=torque.radius_m if torque else 1.0,
        ground=ground.coefficient if ground else 0.0,
        rotor_radius=ground.rotor_radius_m if ground else 0.0,
        ground_from=ground.lowest_m if ground else 1.0,
        fading=hover * own.headroom_per_volt * own.discharge_v_per_s if own else 0.0,
        drag=air.rotor_drag.per_s if air.rotor_drag else 0.0,
        rate_load=0.25 * air.rate_load.nms / lever if air.rate_load else 0.0,
        roll_lead=lag / body.gains.inertia[0],
        pitch_lead=lag / body.gains.inertia[1],
        lever=lever,
    )
