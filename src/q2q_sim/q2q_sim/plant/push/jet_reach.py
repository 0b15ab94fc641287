"""Bound of the search for the vehicles in a jet, compiled.

The air that meets a vehicle at a gap h below a source now left it tau = h / travel_speed ago. With the
largest speed v and slope s of any vehicle since then, the source was at most H = (1 + v / travel_speed) h
above, so the vehicle is within

    max(near + spread H, widening H)                                                end of the table
    + |1 - carried| v tau + |carried| a tau^2 / 2 + (|slope| s + lean) H            axis from the source now

of the source now; a is HARDEST.

| symbol | name | meaning [unit] |
|---|---|---|
| near + spread H | | bound of the table's ends at all gaps [m] |
| widening | | end over gap of the self-similar jet below the table [-] |
| lean | | largest slope of the axis by crosswind and meander [-] |
"""

import math
from typing import NamedTuple

from q2q_model.compiled import HOT, compiled
from q2q_model.signals.values import Array, Rows
from q2q_sim.air.air_terms import JetTerm
from q2q_sim.plant.body.state_row import VX, VY, VZ
from q2q_sim.plant.push.state_history_ring import SLOPE_X, SLOPE_Y

HARDEST = 10.0
"""a: largest acceleration of a source [m/s^2]."""

SLOPE, SPEED, SLOPE_BEFORE, SPEED_BEFORE, PERIOD = 0, 1, 2, 3, 4
"""Columns of the extremes: squares of the largest slope and speed [m^2/s^2] of any vehicle in this period of
the ring and in the last, and the number of this period."""
EXTREMES_WIDTH = 5


class SearchBound(NamedTuple):
    """Bound of the place of a vehicle in a jet."""

    near: float
    """[m]; 0 if there is no jet."""
    spread: float
    widening: float
    slope: float
    lean: float
    carried: float
    travel_speed: float
    """[m/s]"""


class Extremes(NamedTuple):
    """Largest slope and speed of any vehicle since the air below it left."""

    steepest: float
    """[-]"""
    fastest: float
    """[m/s]"""


class JetReach(NamedTuple):
    """Bound with the speed and slope of this step: max(near + spread h, widening h) + (drift + turn h) h."""

    near: float
    spread: float
    widening: float
    drift: float
    turn: float


def bound_of(jet: JetTerm, ends: Array, lean: float) -> SearchBound:
    """Return the bound of a jet with the ends (a - 1,) of its table."""
    gaps = jet.gaps_m
    return SearchBound(
        near=float(ends[0]),
        spread=max(0.0, *((ends[1:] - ends[0]) / gaps[1:-1]).tolist()) if len(ends) > 1 else 0.0,
        widening=float(ends[-1] / gaps[-1]),
        slope=abs(jet.slope),
        lean=math.hypot(*jet.bend) + lean,
        carried=jet.carried,
        travel_speed=jet.travel_speed_mps,
    )


@compiled(**HOT)
def reach_of(bound: SearchBound, past: Extremes) -> JetReach:
    """Return the bound at the extremes of the past, with which `reach` gives distances [m]."""
    rise = 1.0 + past.fastest / bound.travel_speed
    left = abs(1.0 - bound.carried) * past.fastest / bound.travel_speed
    return JetReach(
        near=bound.near,
        spread=rise * bound.spread,
        widening=rise * bound.widening,
        drift=left + rise * (bound.slope * past.steepest + bound.lean),
        turn=0.5 * abs(bound.carried) * HARDEST / (bound.travel_speed * bound.travel_speed),
    )


@compiled(**HOT)
def reach(to: JetReach, gap: float) -> float:
    """Return the largest distance of a vehicle in a jet from its source [m]."""
    return max(to.near + to.spread * gap, to.widening * gap) + (to.drift + to.turn * gap) * gap


@compiled(**HOT)
def update_extremes(state: Array, ring: Array, rows: Rows, extremes: Array) -> Extremes:
    """Raise the extremes (EXTREMES_WIDTH,) to slopes and speeds of this step; return those of the past.

    `state` is (n, STATE_WIDTH); `ring` and `rows` are those of an Air.
    """
    n, slots = state.shape[0], ring.shape[0]
    period = rows[n] // slots
    slot = rows[n] - period * slots
    if period != extremes[PERIOD]:
        extremes[SLOPE_BEFORE], extremes[SPEED_BEFORE] = extremes[SLOPE], extremes[SPEED]
        extremes[SLOPE], extremes[SPEED], extremes[PERIOD] = 0.0, 0.0, period
    slope, speed = extremes[SLOPE], extremes[SPEED]
    for i in range(n):
        sx, sy = ring[slot, i, SLOPE_X], ring[slot, i, SLOPE_Y]
        vx, vy, vz = state[i, VX], state[i, VY], state[i, VZ]
        slope, speed = max(slope, sx * sx + sy * sy), max(speed, vx * vx + vy * vy + vz * vz)
    extremes[SLOPE], extremes[SPEED] = slope, speed
    steepest = math.sqrt(max(slope, extremes[SLOPE_BEFORE]))
    return Extremes(steepest, math.sqrt(max(speed, extremes[SPEED_BEFORE])))
