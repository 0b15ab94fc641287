"""Motion that every vehicle wants: back to its reference, and never nearer to a zone than it can stop.

On its reference a vehicle wants the reference's acceleration, else that of the tracking law of (20),
e'' = -k_d e' - k_p e, within acc_max. Control barriers (`barrier`) correct both. Where jerk is bounded, the
acceleration approaches the wanted one with the time constant LAG.
"""

from typing import NamedTuple

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array
from q2q_planner.online.safe.barrier import BarrierLaw, BarrierStates, push_apart
from q2q_planner.online.safe.broad_phase import Pairs
from q2q_planner.online.safe.committed_motion import (
    CommittedMotion,
    Mask,
    MotionRows,
    ReferenceRows,
    length,
)
from q2q_planner.online.safe.jerk_limited import jerk_towards
from q2q_planner.online.safe.safe_replanner_params import SafeReplannerParams
from q2q_planner.online.safe.traffic import TrafficRows, TrafficTable, in_pairs

FLOOR = 1e-3
"""Distance that a new motion keeps from the zone, added to all growth [m]."""
LAG = 0.05
"""Time constant at which the acceleration approaches the wanted one where jerk is bounded [s]."""


class WantedMotion(NamedTuple):
    """New motion of the swarm, held for `hold`."""

    acc: Array
    """Acceleration [m/s^2], (n, 3); where jerk is bounded, that at the beginning."""
    jerk: Array
    """[m/s^3], (n, 3)."""
    pushed: Mask
    """Whom a barrier turned from its wanted acceleration, (n,)."""


class _WantedLaw(NamedTuple):
    """Law of the wanted motion; fields of SafeReplannerParams."""

    k_p: float
    k_d: float
    acc: float
    jerk: float
    keep: float
    """Distance to keep from the grown zone [m]."""
    barrier: BarrierLaw
    avoids: bool


def wanted_motion(
    committed: CommittedMotion, reference: ReferenceRows, traffic: TrafficTable, params: SafeReplannerParams
) -> WantedMotion:
    """Return the motion that the swarm wants."""
    acc, jerk, pushed = _wanted(
        committed.rows, reference, traffic.rows, traffic.pairs, _law(traffic.own, params)
    )
    return WantedMotion(acc, jerk, pushed)


def _law(own: int, params: SafeReplannerParams) -> _WantedLaw:
    poles = 2.0 * params.approach, params.approach**2
    barrier = BarrierLaw(own, params.eps, params.d, *poles, params.around, params.height)
    keep = params.margin + FLOOR
    return _WantedLaw(params.k_p, params.k_d, params.acc_max, params.jerk_max, keep, barrier, params.enabled)


@compiled
def _wanted(
    rows: MotionRows, reference: ReferenceRows, traffic: TrafficRows, pairs: Pairs, law: _WantedLaw
) -> tuple[Array, Array, Mask]:
    own = rows.hold.size
    acc = _towards_reference(rows, reference, law)
    pushed = np.zeros(own, np.bool_)
    if law.avoids and pairs.i.size > 0:
        pushed = _apart(acc, reference, traffic, pairs, law)
    if law.jerk == 0.0:
        return acc, rows.jerk.copy(), pushed
    begin = np.empty_like(acc)
    for row in range(own):
        begin[row] = reference.acc[row] if rows.on_reference[row] else rows.acc[row]
    return begin, jerk_towards(acc, begin, LAG, law.jerk), pushed


@compiled
def _towards_reference(rows: MotionRows, reference: ReferenceRows, law: _WantedLaw) -> Array:
    """Return the accelerations (n, 3) on the reference, or back to it."""
    acc = reference.acc.copy()
    for row in range(rows.hold.size):
        if rows.on_reference[row]:
            continue
        for axis in range(3):
            rate = rows.vel[row, axis] - reference.vel[row, axis]
            acc[row, axis] += -law.k_d * rate - law.k_p * (rows.pos[row, axis] - reference.pos[row, axis])
        _limit(acc, row, law.acc)
    return acc


@compiled
def _limit(acc: Array, row: int, most: float) -> None:
    """Clip a row of accelerations (n, 3) to the norm `most` [m/s^2]."""
    size = length(acc[row, 0], acc[row, 1], acc[row, 2])
    if size > most:
        acc[row] *= most / size


@compiled
def _apart(acc: Array, reference: ReferenceRows, traffic: TrafficRows, pairs: Pairs, law: _WantedLaw) -> Mask:
    """Correct the accelerations (n, 3) in place by barriers; return which changed, (n,)."""
    own = len(acc)
    meets, turned = in_pairs(pairs, len(traffic.pos)), np.zeros_like(traffic.pos)
    turned[:own] = acc
    for row in range(own):
        if meets[row]:
            _limit(turned, row, law.acc)
    wide = np.empty((pairs.i.size, 2))
    for row in range(pairs.i.size):
        i, j = pairs.i[row], pairs.j[row]
        wide[row, 0] = traffic.growth[i, 0] + traffic.growth[j, 0] + law.keep
        wide[row, 1] = traffic.growth[i, 1] + traffic.growth[j, 1]
    goals = traffic.pos.copy()
    goals[:own] = reference.pos
    states = BarrierStates(traffic.pos, traffic.vel, goals)
    pushed = push_apart(turned, states, pairs, wide, law.barrier)[:own]
    for row in range(own):
        if pushed[row]:
            _limit(turned, row, law.acc)
        for axis in range(3):
            pushed[row] |= turned[row, axis] != acc[row, axis]
            acc[row, axis] = turned[row, axis]
    return pushed
