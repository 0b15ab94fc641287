"""Desired motion of every vehicle: back to its reference, and never nearer to a zone than it can stop.

On its reference a vehicle's desired acceleration is that of the reference, else that of the tracking law of
(20), e'' = -k_d e' - k_p e, within acc_max; where jerk is bounded, the shift e shrinks as fast as it can stop
(`approach_speed`), and the acceleration approaches the desired one with the time constant LAG, or `hold` if
that is longer. Control barriers (`barrier`) correct both. A motion of bounded jerk that leads beyond
speed_max before it rests is not flown: the rest of the old one does not.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array, Mask
from q2q_planner.online.safe.choice.barrier import BarrierLaw, BarrierStates, filter_accelerations
from q2q_planner.online.safe.motion.committed_motion import CommittedMotion, MotionRows
from q2q_planner.online.safe.motion.followed_reference import ReferenceRows
from q2q_planner.online.safe.motion.safe_replanner_params import SafeReplannerParams
from q2q_planner.online.safe.motion.traffic import TrafficRows, TrafficTable, rows_in_pairs
from q2q_planner.online.safe.motion.vectors import length, norm
from q2q_planner.online.safe.stopping.approach_speed import ApproachLaw, approach_speed
from q2q_planner.online.safe.stopping.broad_phase import Pairs
from q2q_planner.online.safe.stopping.jerk_limited import jerk_towards, speed_bound

Vector = tuple[float, float, float]
"""x, y and z, world."""

FLOOR = 1e-3
"""Distance that a new motion keeps from the zone, added to all growth [m]."""
RETURN_BRAKE = 0.75
"""Share of acc_max by which a return of bounded jerk brakes; the rest is for ramps and the reference."""
TINY = 1e-9
"""Shift below which its direction does not matter [m]."""
HEADROOM, LEAST = 0.95, 0.5
"""Largest and least share of speed_max up to which a vehicle of bounded jerk returns: in between less by the
speed that it still gains while acc_max is taken back."""
AS_ASKED, PUSHED, TOO_FAST = 0, 1, 2

Kinds = NDArray[np.int8]


class DesiredMotion(NamedTuple):
    """New motion of the swarm, held for `hold`."""

    acc: Array
    """Acceleration [m/s^2], (n, 3); where jerk is bounded, that at the beginning."""
    jerk: Array
    """[m/s^3], (n, 3)."""
    kind: Kinds
    """AS_ASKED, PUSHED by a barrier, or TOO_FAST: of bounded jerk, it leads beyond speed_max, (n,)."""


class _DesiredLaw(NamedTuple):
    """Law of the desired motion; fields of SafeReplannerParams."""

    k_p: float
    """[1/s^2]."""
    k_d: float
    """[1/s]."""
    acc: float
    """Largest acceleration [m/s^2]."""
    jerk: float
    """Largest jerk of an axis [m/s^3]; 0 does not bound it."""
    hold: float
    """Time for which a motion is held [s]."""
    lag: float
    """Of the approach to the desired acceleration [s]."""
    keep: float
    """Distance to keep from the grown zone [m]."""
    back: ApproachLaw
    """Of the return to the reference, where jerk is bounded."""
    speed: float
    """Up to which a vehicle of bounded jerk returns [m/s]."""
    speed_max: float
    """Largest speed of a vehicle of bounded jerk [m/s]."""
    barrier: BarrierLaw
    avoids: bool


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
        params.k_p,
        params.k_d,
        params.acc_max,
        params.jerk_max,
        params.hold,
        params.lag,
        params.margin + FLOOR,
        ApproachLaw(pole, RETURN_BRAKE * params.acc_max),
        _return_speed(params),
        params.speed_max,
        barrier,
        params.enabled,
    )


def _return_speed(params: SafeReplannerParams) -> float:
    """Return the speed up to which a vehicle of bounded jerk returns [m/s]."""
    if params.jerk_max == 0.0:
        return params.speed_max
    gained = 0.5 * params.acc_max**2 / params.jerk_max
    return max(LEAST * params.speed_max, min(HEADROOM * params.speed_max, params.speed_max - gained))


@compiled
def _desired(
    rows: MotionRows, reference: ReferenceRows, traffic: TrafficRows, pairs: Pairs, law: _DesiredLaw
) -> tuple[Array, Array, Kinds]:
    own = rows.hold.size
    acc = _towards_reference(rows, reference, law)
    kind = np.full(own, AS_ASKED, np.int8)
    if law.avoids and pairs.i.size > 0:
        pushed = _apart(acc, reference, traffic, pairs, law)
        for row in range(own):
            if pushed[row]:
                kind[row] = PUSHED
    if law.jerk == 0.0:
        return acc, rows.jerk.copy(), kind
    begin = np.empty_like(acc)
    for row in range(own):
        begin[row] = reference.acc[row] if rows.on_reference[row] else rows.acc[row]
    jerk = jerk_towards(acc, begin, law.lag, law.jerk)
    for row in range(own):
        if speed_bound(rows.vel, begin, jerk, row, (law.hold, law.jerk)) > law.speed_max:
            kind[row] = TOO_FAST
    return begin, jerk, kind


@compiled
def _towards_reference(rows: MotionRows, reference: ReferenceRows, law: _DesiredLaw) -> Array:
    """Return the accelerations (n, 3) on the reference, or back to it."""
    acc = reference.acc.copy()
    for row in range(rows.hold.size):
        if rows.on_reference[row]:
            continue
        if law.jerk > 0.0:
            _return_fast(acc, rows, reference, row, law)
        else:
            for axis in range(3):
                rate = rows.vel[row, axis] - reference.vel[row, axis]
                shift = rows.pos[row, axis] - reference.pos[row, axis]
                acc[row, axis] += -law.k_d * rate - law.k_p * shift
        _limit(acc, row, law.acc)
    return acc


@compiled
def _return_fast(acc: Array, rows: MotionRows, reference: ReferenceRows, row: int, law: _DesiredLaw) -> None:
    """Add the acceleration by which the shift e of a row follows e' = -w(|e|) e / |e| (approach_speed).

    The velocity of a faster reference counts up to `law.speed`. Its acceleration does not where the bound of
    the speed acts: it would lead beyond it.
    """
    vel, asked = rows.vel[row], reference.vel[row]
    share = _share(asked, law.speed)
    ahead = share * asked[0], share * asked[1], share * asked[2]
    if share < 1.0:
        acc[row] = 0.0
    x, y, z = _apart_by(rows.pos, reference.pos, row)
    u, v, w = vel[0] - ahead[0], vel[1] - ahead[1], vel[2] - ahead[2]
    far = max(length(x, y, z), TINY)
    speed, slope = approach_speed(far, law.back)
    most = _most_closing((x / far, y / far, z / far), ahead, law.speed)
    if speed > most:
        speed, slope, acc[row] = most, 0.0, 0.0
    along = (x * u + y * v + z * w) / far
    turning = speed / far
    for axis, shift, rate in ((0, x, u), (1, y, v), (2, z, w)):
        out = shift / far
        aside = rate - along * out
        acc[row, axis] -= law.back.pole * (rate + speed * out) + slope * along * out + turning * aside


@compiled
def _apart_by(some: Array, other: Array, row: int) -> Vector:
    """Return the difference of a row of two arrays (n, 3)."""
    return some[row, 0] - other[row, 0], some[row, 1] - other[row, 1], some[row, 2] - other[row, 2]


@compiled
def _most_closing(out: Vector, vel: Vector, most: float) -> float:
    """Return the largest w, 0 or more, at which a reference's velocity less w `out` is within `most`."""
    (x, y, z), (u, v, w) = out, vel
    along = x * u + y * v + z * w
    left = along * along + most * most - (u * u + v * v + w * w)
    return max(0.0, along + np.sqrt(left)) if left > 0.0 else 0.0


@compiled
def _share(vector: Array, most: float) -> float:
    """Return the share of a vector, (3,), up to the norm `most`: at most 1."""
    size = norm(vector)
    return float(most / size) if size > most else 1.0


@compiled
def _limit(acc: Array, row: int, most: float) -> None:
    """Clip a row of accelerations (n, 3) to the norm `most` [m/s^2]."""
    acc[row] *= _share(acc[row], most)


@compiled
def _apart(
    acc: Array, reference: ReferenceRows, traffic: TrafficRows, pairs: Pairs, law: _DesiredLaw
) -> Mask:
    """Correct the accelerations (n, 3) in place by barriers; return which changed, (n,)."""
    own = len(acc)
    meets, turned = rows_in_pairs(pairs, len(traffic.pos)), np.zeros_like(traffic.pos)
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
    pushed = filter_accelerations(turned, states, pairs, wide, law.barrier)[:own]
    for row in range(own):
        if pushed[row]:
            _limit(turned, row, law.acc)
        for axis in range(3):
            pushed[row] |= turned[row, axis] != acc[row, axis]
            acc[row, axis] = turned[row, axis]
    return pushed
