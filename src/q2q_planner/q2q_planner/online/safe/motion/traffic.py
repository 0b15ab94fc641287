"""Table of all vehicles of a tick: the swarm's rows first, then those of external vehicles.

Uncertainty grows a vehicle's zone by g0 [m] now and by g1 [m/s] ahead, for vehicles of the swarm as in
`tracking_uncertainty`. An external vehicle with a state of age A may have accelerated by acc_max since,
and may for another `hold`, so its velocity is known within acc_max (A + hold) and its position within half of
that times A + hold; neither changes by more than `speed_max` allows; and it may be off its own trajectory by
`tracking`. The motion that an external vehicle under this law *certainly* flies has less uncertainty: it
brakes from `hold` after its message on, since any other choice was proven against us.

Without bounded jerk, a vehicle on its reference and in no pair holds its acceleration even beyond acc_max, so
its stopping distance counts that acceleration while it is held.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array, Mask
from q2q_planner.online.last_known_states import KnownStates
from q2q_planner.online.safe.motion.committed_motion import CommittedMotion, MotionRows
from q2q_planner.online.safe.motion.followed_reference import (
    SNAP_POS,
    SNAP_VEL,
    FollowBounds,
    ReferenceRows,
    follow_bounds,
    followed_rows,
    near_rows,
)
from q2q_planner.online.safe.motion.safe_replanner_params import SafeReplannerParams
from q2q_planner.online.safe.motion.vectors import norm
from q2q_planner.online.safe.stopping.braking import Motions, motion_after
from q2q_planner.online.safe.stopping.broad_phase import Pairs, StoppingSpace, SweepLimits, broad_phase

NO_PAIRS = Pairs(np.zeros(0, dtype=np.intp), np.zeros(0, dtype=np.intp))
_EMPTY = np.zeros((0, 3))


class TrafficRows(NamedTuple):
    """Where vehicles are, and how far that is known."""

    pos: Array
    """[m], (rows, 3); external vehicles extrapolated at constant velocity."""
    vel: Array
    """[m/s], (rows, 3)."""
    growth: Array
    """g0 [m] and g1 [m/s], (rows, 2)."""


@dataclass(frozen=True, slots=True)
class TrafficTable:
    """All vehicles at a tick."""

    own: int
    """Rows of the swarm."""
    rows: TrafficRows
    certain: Motions
    """Motion that each external vehicle certainly flies, (m, ...)."""
    pairs: Pairs
    """Rows i < j of pairs that can affect each other, i of the swarm."""


_ALONE = TrafficTable(
    0,
    TrafficRows(_EMPTY, _EMPTY, np.zeros((0, 2))),
    Motions(_EMPTY, _EMPTY, _EMPTY, np.zeros(0), np.zeros((0, 2)), _EMPTY),
    NO_PAIRS,
)
"""Table without external vehicles."""


class TrafficLimits(NamedTuple):
    """What decides who may snap onto its reference, and who may meet whom."""

    follow: FollowBounds
    jerk_limited: bool
    """Jerk is bounded."""
    hold: float
    """Time for which a motion is held [s]."""
    ramps: float
    """Longest delay of a stop by ramps of the acceleration [s]."""
    acc: float
    """Largest acceleration of a vehicle [m/s^2]."""
    eps: float
    """Radius of the zone [m]."""
    d: float
    """Half height of the zone [m]."""
    pole: float
    """Of the approach [1/s]."""


def limits_of(params: SafeReplannerParams, dt: float = 0.0) -> TrafficLimits:
    """Return the limits of a replanner's parameters, `dt` [s] after the tick before."""
    jerk_limited, ramps = params.jerk_max > 0.0, _longest_ramps(params)
    zone = params.eps, params.d, params.pole
    return TrafficLimits(follow_bounds(params, dt), jerk_limited, params.hold, ramps, params.acc_max, *zone)


def traffic_at(
    committed: CommittedMotion,
    reference: ReferenceRows,
    growth: Array,
    states: KnownStates,
    params: SafeReplannerParams,
) -> tuple[CommittedMotion, TrafficTable]:
    """Return the motion with vehicles snapped onto their references, and the table of all vehicles.

    A vehicle on its reference without a pair stays on it, even if that jumps, unless jerk is bounded.
    """
    external, own = _external_rows(states, params), len(committed.names)
    swarm = TrafficRows(committed.rows.pos, committed.rows.vel, growth)
    limits = limits_of(params, committed.dt)
    put, there, pairs = _placed(committed.rows, reference, swarm, external.rows, limits)
    rows = committed.rows._replace(pos=there.pos[:own], vel=there.vel[:own], on_reference=put)
    return committed.with_rows(rows), TrafficTable(own, there, external.certain, pairs)


@compiled
def _placed(
    rows: MotionRows,
    reference: ReferenceRows,
    swarm: TrafficRows,
    external: TrafficRows,
    limits: TrafficLimits,
) -> tuple[Mask, TrafficRows, Pairs]:
    """Return who is put onto its reference (own,), and the rows and pairs of the table."""
    own = rows.hold.size
    pos, vel = np.concatenate((rows.pos, external.pos)), np.concatenate((rows.vel, external.vel))
    there = TrafficRows(pos, vel, np.concatenate((swarm.growth, external.growth)))
    near, stays = near_rows(rows, reference), rows.on_reference
    if limits.jerk_limited:
        near = near & followed_rows(rows, reference, limits.follow)
        stays = stays & near
    put = near | stays
    _put(there, rows, reference, put)
    pairs = interacting_pairs(own, there, _held(len(pos), rows, reference, put, limits), limits)
    if np.any(rows_in_pairs(pairs, len(pos))[:own] & put & ~near):
        put = near
        _put(there, rows, reference, put)
        pairs = interacting_pairs(own, there, _held(len(pos), rows, reference, put, limits), limits)
    return put, there, pairs


@compiled
def _put(there: TrafficRows, rows: MotionRows, reference: ReferenceRows, put: Mask) -> None:
    """Write the swarm's positions and velocities: those of the reference where a vehicle is put onto it."""
    for row in range(put.size):
        there.pos[row] = reference.pos[row] if put[row] else rows.pos[row]
        there.vel[row] = reference.vel[row] if put[row] else rows.vel[row]


@compiled
def _held(count: int, rows: MotionRows, reference: ReferenceRows, put: Mask, limits: TrafficLimits) -> Array:
    """Return the largest acceleration that each of `count` rows holds, now or on its old motion [m/s^2]."""
    held = np.full(count, limits.acc)
    if limits.jerk_limited:
        return held
    for row in range(put.size):
        if put[row]:
            held[row] = max(held[row], norm(reference.acc[row]))
        if rows.hold[row] > 0.0:
            held[row] = max(held[row], norm(rows.acc[row]))
    return held


@compiled
def rows_in_pairs(pairs: Pairs, count: int) -> Mask:
    """Return which of `count` rows are in a pair, (count,)."""
    found = np.zeros(count, np.bool_)
    for row in range(pairs.i.size):
        found[pairs.i[row]] = found[pairs.j[row]] = True
    return found


def _external_rows(states: KnownStates, params: SafeReplannerParams) -> TrafficTable:
    """Return the rows of external vehicles."""
    if not states.names:
        return _ALONE
    age, most, step = states.age + params.hold, params.acc_max, params.hold
    fastest = params.speed_max + np.sqrt((states.vel**2).sum(-1))
    spread = np.minimum(0.5 * most * age**2, fastest * age) + SNAP_POS + params.tracking
    growth = np.stack([spread, np.minimum(most * age, fastest) + SNAP_VEL], -1)
    count = len(states.names)
    still = np.zeros((count, 3))
    motions = Motions(states.pos, states.vel, still, np.minimum(step, states.age), growth, still)
    pos, vel = motion_after(motions, states.age, most)
    rest = np.sqrt((states.vel**2).sum(-1)) / most
    slack = params.tracking - 0.5 * most * step**2 - most * step * rest - SNAP_POS - SNAP_VEL * rest
    hold, slacks = np.maximum(step - states.age, 0.0), np.stack([slack, np.zeros(count)], -1)
    certain = Motions(pos, vel, still, hold, slacks, still)
    there = states.pos + states.vel * states.age[:, None]
    return TrafficTable(0, TrafficRows(there, states.vel, growth), certain, NO_PAIRS)


@compiled
def interacting_pairs(own: int, rows: TrafficRows, held: Array, limits: TrafficLimits) -> Pairs:
    """Return the pairs i < j that can affect each other, i of the swarm's `own` rows.

    `held` (rows,) is that of `stopping_distances`.
    """
    count = len(rows.pos)
    if count < 2:
        none = np.zeros(0, np.intp)
        return Pairs(none, none)
    sweep = SweepLimits(own, limits.eps, limits.d, limits.pole, 2.0 * limits.acc)
    stopping = stopping_distances(rows, held, limits)
    return broad_phase(rows.pos, rows.vel, StoppingSpace(stopping, rows.growth), sweep)


def _longest_ramps(params: SafeReplannerParams) -> float:
    """Return by how much ramps of the acceleration delay a stop at most [s]; 0 if jerk is not bounded."""
    return params.hold + 4.0 * params.acc_max / params.jerk_max if params.jerk_max > 0.0 else 0.0


@compiled
def stopping_distances(rows: TrafficRows, held: Array, limits: TrafficLimits) -> Array:
    """Return the stopping distance of each row with growth [m], (rows,).

    `held` is the largest acceleration that each holds [m/s^2], (rows,).
    """
    hold, most, vel = limits.hold + limits.ramps, limits.acc, rows.vel
    fast = np.empty(len(vel))
    for row in range(fast.size):
        fast[row] = norm(vel[row]) + held[row] * hold
    top, rate = float(fast.max()), 2.0 * float(rows.growth[:, 1].max())
    rest = hold + (top + rate) / most
    stopping: Array = fast * (hold + 0.5 * fast / most) + rows.growth[:, 0] + rows.growth[:, 1] * rest
    return stopping
