"""Table of all vehicles of a tick: the swarm's rows first, then those of external vehicles.

Uncertainty grows a vehicle's zone by g0 [m] now and by g1 [m/s] ahead. For a vehicle of the swarm it is
`tracking`, and `drift` while measurements are missing for longer than `grace`: a tube that is learned from
flights covers their gaps. An external vehicle with a state of age A may have accelerated by acc_max since,
and may for another `hold`, so its velocity is known within acc_max (A + hold) and its position within half of
that times A + hold; neither changes by more than `speed_max` allows; and it may be off its own trajectory by
`tracking`. The motion that an external vehicle under this law *certainly* flies has less uncertainty: it
brakes from `hold` after its message on, since any other choice was proven against us.
"""

from dataclasses import dataclass, replace

import numpy as np

from q2q_model.signals.values import Array, SwarmSetpoint
from q2q_planner.online.safe.braking import Motions, motion_after
from q2q_planner.online.safe.broad_phase import Pairs, StoppingSpace, SweepLimits, broad_phase
from q2q_planner.online.safe.committed_motion import (
    SNAP_POS,
    SNAP_VEL,
    CommittedMotion,
    Mask,
    can_be_followed,
    near_reference,
)
from q2q_planner.online.safe.last_known_states import KnownStates
from q2q_planner.online.safe.safe_replanner_params import SafeReplannerParams

NO_PAIRS = Pairs(np.zeros(0, dtype=np.intp), np.zeros(0, dtype=np.intp))


_EMPTY = np.zeros((0, 3))


@dataclass(frozen=True, slots=True)
class TrafficTable:
    """All vehicles at a tick."""

    own: int
    """Rows of the swarm."""
    pos: Array
    """[m], (rows, 3); external vehicles extrapolated at constant velocity."""
    vel: Array
    """[m/s], (rows, 3)"""
    growth: Array
    """g0 [m] and g1 [m/s], (rows, 2)."""
    certain: Motions
    """Motion that each external vehicle certainly flies, (m, ...)."""
    pairs: Pairs
    """Rows i < j of pairs that can affect each other, i of the swarm."""

    @property
    def meets(self) -> Mask:
        """Return which vehicles of the swarm are in a pair, (own,)."""
        found = np.zeros(len(self.pos), np.bool_)
        found[self.pairs.i] = True
        found[self.pairs.j] = True
        return found[: self.own]


_ALONE = TrafficTable(
    0,
    _EMPTY,
    _EMPTY,
    np.zeros((0, 2)),
    Motions(_EMPTY, _EMPTY, _EMPTY, np.zeros(0), np.zeros((0, 2)), _EMPTY),
    NO_PAIRS,
)
"""Table without external vehicles."""


def own_uncertainty(
    committed: CommittedMotion, states: KnownStates | None, params: SafeReplannerParams
) -> Array:
    """Return the growth (n, 2) of the swarm's zones; `states` None assumes ideal tracking."""
    growth = np.tile([params.tracking + SNAP_POS, SNAP_VEL], (len(committed.names), 1))
    if states is None:
        return growth
    unseen = np.maximum(np.minimum(states.age, params.forget) - params.grace, 0.0)
    growth[:, 0] += params.drift * unseen
    growth[:, 1] += np.where(unseen > 0.0, params.drift, 0.0)
    return growth


def off_trajectory(
    committed: CommittedMotion, states: KnownStates | None, params: SafeReplannerParams
) -> Mask:
    """Return which vehicles are off their modified trajectory by more than their age allows, (n,)."""
    if states is None:
        return np.zeros(len(committed.names), np.bool_)
    age = np.minimum(states.age, params.forget)
    error = states.pos + states.vel * age[:, None] - committed.pos
    since = params.drift * age + 0.5 * params.acc_max * age**2
    if params.tracking_z > 0.0:
        above, aside = np.abs(error[:, 2]), np.hypot(error[:, 0], error[:, 1])
        return np.asarray((aside > params.tracking + since) | (above > params.tracking_z + since))
    away = np.sqrt((error**2).sum(-1))
    return np.asarray(away > params.tracking + since)


def traffic_at(
    committed: CommittedMotion,
    setpoint: SwarmSetpoint,
    growth: Array,
    states: KnownStates,
    params: SafeReplannerParams,
) -> tuple[CommittedMotion, TrafficTable]:
    """Return the motion with vehicles snapped onto their references, and the table of all vehicles.

    A vehicle on its reference without a pair stays on it, even if that jumps, unless jerk is bounded.
    """
    external = _external_rows(states, params)
    near = near_reference(committed, setpoint)
    stays = committed.on_reference
    if params.jerk_max > 0.0:
        near = near & can_be_followed(committed, setpoint, params)
        stays = stays & near
    for stay in (stays, np.zeros_like(near)):
        put = near | stay
        placed = replace(
            committed,
            pos=np.where(put[:, None], setpoint.pos, committed.pos),
            vel=np.where(put[:, None], setpoint.vel, committed.vel),
            on_reference=put,
        )
        traffic = _with_pairs(placed, growth, external, params)
        if not (traffic.meets & put & ~near).any():
            break
    return placed, traffic


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
    return TrafficTable(0, there, states.vel, growth, certain, NO_PAIRS)


def _with_pairs(
    committed: CommittedMotion, growth: Array, external: TrafficTable, params: SafeReplannerParams
) -> TrafficTable:
    whole = TrafficTable(
        len(committed.names),
        np.concatenate([committed.pos, external.pos]),
        np.concatenate([committed.vel, external.vel]),
        np.concatenate([growth, external.growth]),
        external.certain,
        NO_PAIRS,
    )
    if len(whole.pos) < 2:
        return whole
    stopping, speed = _stopping_distances(whole, params)
    closing = 2.0 * speed + 2.0 * float(whole.growth[:, 1].max())
    approach = 2.0 * closing / params.approach + 2.0 * params.acc_max / params.approach**2
    reach = (
        params.eps
        + params.margin
        + 2.0 * max(float(stopping.max()), float(whole.growth[:, 0].max()) + approach)
    )
    limits = SweepLimits(whole.own, params.eps, params.d, reach, params.approach, 2.0 * params.acc_max)
    return replace(
        whole,
        pairs=broad_phase(whole.pos, whole.vel, StoppingSpace(stopping, whole.growth), limits),
    )


def _longest_ramps(params: SafeReplannerParams) -> float:
    """Return by how much ramps of the acceleration delay a stop at most [s]; 0 if jerk is not bounded."""
    return params.hold + 4.0 * params.acc_max / params.jerk_max if params.jerk_max > 0.0 else 0.0


def _stopping_distances(traffic: TrafficTable, params: SafeReplannerParams) -> tuple[Array, float]:
    """Return the stopping distance of each row with growth [m], (rows,), and the largest speed [m/s]."""
    hold = params.hold + _longest_ramps(params)
    fast = np.sqrt((traffic.vel**2).sum(-1)) + params.acc_max * hold
    top, rate = float(fast.max()), 2.0 * float(traffic.growth[:, 1].max())
    rest = hold + (top + rate) / params.acc_max
    distance = fast * (hold + 0.5 * fast / params.acc_max)
    return distance + traffic.growth[:, 0] + traffic.growth[:, 1] * rest, top
