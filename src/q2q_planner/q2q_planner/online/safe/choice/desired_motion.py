"""Desired motion of every vehicle: back to its reference, and never nearer to a zone than it can stop.

A vehicle follows its reference or returns to it (`return_acceleration`). Where jerk is bounded, the
acceleration approaches the desired one with the time constant LAG, or `hold` if that is longer. Control
barriers (`barrier`, `height_bound`) correct both. A motion that rests too low, or one of bounded jerk that
leads beyond speed_max before it rests, is not flown: the rest of the old one does neither.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array, Mask
from q2q_planner.online.safe.choice.barrier import BarrierLaw, BarrierStates, filter_accelerations
from q2q_planner.online.safe.choice.height_bound import (
    Candidates,
    HeightLaw,
    candidates_of,
    is_too_low,
    least_climbs,
)
from q2q_planner.online.safe.choice.return_acceleration import ReturnLaw, return_law, towards_reference
from q2q_planner.online.safe.motion.committed_motion import CommittedMotion, MotionRows
from q2q_planner.online.safe.motion.followed_reference import ReferenceRows
from q2q_planner.online.safe.motion.safe_replanner_params import SafeReplannerParams
from q2q_planner.online.safe.motion.traffic import TrafficRows, TrafficTable, rows_in_pairs
from q2q_planner.online.safe.motion.vectors import limit_row
from q2q_planner.online.safe.stopping.braking import BrakingLaw
from q2q_planner.online.safe.stopping.broad_phase import Pairs
from q2q_planner.online.safe.stopping.jerk_limited import jerk_towards, speed_bound

FLOOR = 1e-3
"""Distance that a new motion keeps from the zone, added to all growth [m]."""
AS_ASKED, PUSHED, OUT_OF_BOUNDS = 0, 1, 2

Kinds = NDArray[np.int8]


class DesiredMotion(NamedTuple):
    """New motion of the swarm, held for `hold`."""

    acc: Array
    """Acceleration [m/s^2], (n, 3); where jerk is bounded, that at the beginning."""
    jerk: Array
    """[m/s^3], (n, 3)."""
    kind: Kinds
    """AS_ASKED, PUSHED by a barrier, or OUT_OF_BOUNDS: it leads too low, or beyond speed_max, (n,)."""


class _DesiredLaw(NamedTuple):
    """Law of the desired motion; fields of SafeReplannerParams."""

    back: ReturnLaw
    hold: float
    """Time for which a motion is held [s]."""
    lag: float
    """Of the approach to the desired acceleration [s]."""
    keep: float
    """Distance to keep from the grown zone [m]."""
    speed_max: float
    """Largest speed of a vehicle of bounded jerk [m/s]."""
    barrier: BarrierLaw
    lowest: float
    """Lower bound of heights off a reference [m]."""
    avoids: bool


class _Goals(NamedTuple):
    """What barriers know of the swarm besides its states."""

    pos: Array
    """Position of the reference [m], (n, 3)."""
    least: Array
    """Least vertical acceleration [m/s^2], (n,)."""


def desired_motion(
    committed: CommittedMotion, reference: ReferenceRows, traffic: TrafficTable, params: SafeReplannerParams
) -> DesiredMotion:
    """Return the desired motion of the swarm."""
    law = _law(traffic.own, params)
    return DesiredMotion(*_desired(committed.rows, reference, traffic.rows, traffic.pairs, law))


def _law(own: int, params: SafeReplannerParams) -> _DesiredLaw:
    jerk_limited, pole = params.jerk_max > 0.0, params.pole
    poles = 2.0 * pole, pole**2
    barrier = BarrierLaw(own, params.eps, params.d, *poles, params.around, params.height, jerk_limited)
    return _DesiredLaw(
        return_law(params),
        params.hold,
        params.lag,
        params.margin + FLOOR,
        params.speed_max,
        barrier,
        params.height_min,
        params.enabled,
    )


@compiled
def _desired(
    rows: MotionRows, reference: ReferenceRows, traffic: TrafficRows, pairs: Pairs, law: _DesiredLaw
) -> tuple[Array, Array, Kinds]:
    own, jerk = rows.hold.size, law.back.jerk
    height = HeightLaw(law.lowest, law.barrier.k_1, law.barrier.k_0, law.back.acc)
    least = least_climbs(rows, reference, height)
    acc = towards_reference(rows, reference, least, law.back)
    begin, change, kind = acc, rows.jerk.copy(), np.full(own, AS_ASKED, np.int8)
    if law.avoids and pairs.i.size > 0:
        pushed = _apart(acc, _Goals(reference.pos, least), traffic, pairs, law)
        for row in range(own):
            if pushed[row]:
                kind[row] = PUSHED
    if jerk > 0.0:
        begin = np.empty_like(acc)
        for row in range(own):
            begin[row] = reference.acc[row] if rows.on_reference[row] else rows.acc[row]
        change = jerk_towards(acc, begin, law.lag, jerk)
        for row in range(own):
            if speed_bound(rows.vel, begin, change, row, (law.hold, jerk)) > law.speed_max:
                kind[row] = OUT_OF_BOUNDS
    _mark_too_low(kind, candidates_of(rows, reference, (begin, change), law.hold), rows.on_reference, law)
    return begin, change, kind


@compiled
def _mark_too_low(kind: Kinds, candidates: Candidates, on_reference: Mask, law: _DesiredLaw) -> None:
    """Mark in `kind` (n,) whose new motion leads too low; that of a reference that is followed is not."""
    braking = BrakingLaw(law.barrier.eps, law.barrier.d, law.back.acc, law.back.jerk)
    for row in range(kind.size):
        if on_reference[row] and kind[row] == AS_ASKED:
            continue
        if is_too_low(candidates, row, law.lowest, braking):
            kind[row] = OUT_OF_BOUNDS


@compiled
def _apart(acc: Array, goals: _Goals, traffic: TrafficRows, pairs: Pairs, law: _DesiredLaw) -> Mask:
    """Correct the accelerations (n, 3) in place by barriers; return which changed, (n,)."""
    own = len(acc)
    meets, turned = rows_in_pairs(pairs, len(traffic.pos)), np.zeros_like(traffic.pos)
    turned[:own] = acc
    for row in range(own):
        if meets[row]:
            limit_row(turned, row, law.back.acc)
    wide = np.empty((pairs.i.size, 2))
    for row in range(pairs.i.size):
        i, j = pairs.i[row], pairs.j[row]
        wide[row, 0] = traffic.growth[i, 0] + traffic.growth[j, 0] + law.keep
        wide[row, 1] = traffic.growth[i, 1] + traffic.growth[j, 1]
    ref = traffic.pos.copy()
    ref[:own] = goals.pos
    states = BarrierStates(traffic.pos, traffic.vel, ref, goals.least)
    pushed = filter_accelerations(turned, states, pairs, wide, law.barrier)[:own]
    for row in range(own):
        if pushed[row]:
            limit_row(turned, row, law.back.acc)
        for axis in range(3):
            pushed[row] |= turned[row, axis] != acc[row, axis]
            acc[row, axis] = turned[row, axis]
    return pushed
