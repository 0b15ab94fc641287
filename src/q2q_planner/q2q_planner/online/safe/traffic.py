"""Table of all vehicles of a tick: the swarm's rows first, then those of external vehicles.

Uncertainty grows a vehicle's zone by g0 [m] now and by g1 [m/s] ahead. For a vehicle of the swarm it is
`tracking`, and `drift` while measurements are missing. An external vehicle with a state of age A may have
accelerated by acc_max since, and may for another `hold`, so its velocity is known within acc_max (A + hold)
and its position within half of that times A + hold; neither changes by more than `speed_max` allows; and it
may be off its own trajectory by `tracking`. The motion that an external vehicle under this law *certainly*
flies has less uncertainty: it brakes from `hold` after its message on, since any other choice was proven
against us.
"""

from dataclasses import dataclass, replace

import numpy as np

from q2q_model.signals.values import Array, SwarmSetpoint
from q2q_planner.online.safe.barrier import Rows
from q2q_planner.online.safe.braking import Motions, motion_after
from q2q_planner.online.safe.broad_phase import broad_phase
from q2q_planner.online.safe.committed_motion import SNAP_POS, SNAP_VEL, CommittedMotion, Mask, near_reference
from q2q_planner.online.safe.last_known_states import Word
from q2q_planner.online.safe.safe_replanner_params import SafeReplannerParams

GRACE = 0.1
"""Age at which a measurement counts as missing [s]: until then `tracking` covers the drift."""

NOBODY: Rows = np.zeros(0, dtype=np.intp)


_EMPTY = np.zeros((0, 3))


@dataclass(frozen=True, slots=True)
class Traffic:
    """All vehicles at a tick."""

    own: int
    """Rows of the swarm."""
    pos: Array
    """[m], (rows, 3); external vehicles extrapolated at constant velocity."""
    vel: Array
    """[m/s], (rows, 3)"""
    growth: Array
    """g0 [m] and g1 [m/s], (rows, 2)."""
    sure: Motions
    """Motion that each external vehicle certainly flies, (m, ...)."""
    pairs: tuple[Rows, Rows]
    """Rows i < j of pairs that can affect each other, i of the swarm."""

    @property
    def meets(self) -> Mask:
        """Return which vehicles of the swarm are in a pair, (own,)."""
        found = np.zeros(len(self.pos), np.bool_)
        found[self.pairs[0]] = True
        found[self.pairs[1]] = True
        return found[: self.own]


_ALONE = Traffic(
    0,
    _EMPTY,
    _EMPTY,
    np.zeros((0, 2)),
    (_EMPTY, _EMPTY, _EMPTY, np.zeros(0), np.zeros((0, 2))),
    (NOBODY, NOBODY),
)
"""Table without external vehicles."""


def own_uncertainty(held: CommittedMotion, word: Word | None, params: SafeReplannerParams) -> Array:
    """Return the growth (n, 2) of the swarm's zones; `word` None assumes ideal tracking."""
    growth = np.tile([params.tracking + SNAP_POS, SNAP_VEL], (len(held.names), 1))
    if word is None:
        return growth
    unseen = np.maximum(np.minimum(word.age, params.forget) - GRACE, 0.0)
    growth[:, 0] += params.drift * unseen
    growth[:, 1] += np.where(unseen > 0.0, params.drift, 0.0)
    return growth


def astray(held: CommittedMotion, word: Word | None, params: SafeReplannerParams) -> Mask:
    """Return which vehicles are off their modified trajectory by more than their age allows, (n,)."""
    if word is None:
        return np.zeros(len(held.names), np.bool_)
    age = np.minimum(word.age, params.forget)
    away = np.sqrt(((word.pos + word.vel * age[:, None] - held.pos) ** 2).sum(-1))
    return np.asarray(away > params.tracking + params.drift * age + 0.5 * params.acc_max * age**2)


def scene_of(
    held: CommittedMotion, setpoint: SwarmSetpoint, growth: Array, word: Word, params: SafeReplannerParams
) -> tuple[CommittedMotion, Traffic]:
    """Return the motion with vehicles snapped onto their references, and the table of all vehicles.

    A vehicle on its reference without a pair stays on it, even if the reference jumps.
    """
    strange = _strangers(word, params)
    near = near_reference(held, setpoint)
    for stay in (held.on_reference, np.zeros_like(near)):
        put = near | stay
        placed = replace(
            held,
            pos=np.where(put[:, None], setpoint.pos, held.pos),
            vel=np.where(put[:, None], setpoint.vel, held.vel),
            on_reference=put,
        )
        scene = _with_pairs(placed, growth, strange, params)
        if not (scene.meets & put & ~near).any():
            break
    return placed, scene


def _strangers(word: Word, params: SafeReplannerParams) -> Traffic:
    """Return the rows of external vehicles."""
    if not word.names:
        return _ALONE
    age, most, step = word.age + params.hold, params.acc_max, params.hold
    fastest = params.speed_max + np.sqrt((word.vel**2).sum(-1))
    spread = np.minimum(0.5 * most * age**2, fastest * age) + SNAP_POS + params.tracking
    growth = np.stack([spread, np.minimum(most * age, fastest) + SNAP_VEL], -1)
    count = len(word.names)
    still = np.zeros((count, 3))
    pos, vel = motion_after((word.pos, word.vel, still, np.minimum(step, word.age), growth), word.age, most)
    rest = np.sqrt((word.vel**2).sum(-1)) / most
    slack = params.tracking - 0.5 * most * step**2 - most * step * rest - SNAP_POS - SNAP_VEL * rest
    sure = pos, vel, still, np.maximum(step - word.age, 0.0), np.stack([slack, np.zeros(count)], -1)
    there = word.pos + word.vel * word.age[:, None]
    return Traffic(0, there, word.vel, growth, sure, (NOBODY, NOBODY))


def _with_pairs(
    held: CommittedMotion, growth: Array, strange: Traffic, params: SafeReplannerParams
) -> Traffic:
    whole = Traffic(
        len(held.names),
        np.concatenate([held.pos, strange.pos]),
        np.concatenate([held.vel, strange.vel]),
        np.concatenate([growth, strange.growth]),
        strange.sure,
        (NOBODY, NOBODY),
    )
    if len(whole.pos) < 2:
        return whole
    ways, speed = _ways_to_rest(whole, params)
    closing = 2.0 * speed + 2.0 * float(whole.growth[:, 1].max())
    approach = 2.0 * closing / params.approach + 2.0 * params.acc_max / params.approach**2
    reach = (
        params.eps + params.margin + 2.0 * max(float(ways.max()), float(whole.growth[:, 0].max()) + approach)
    )
    limits = whole.own, params.eps, params.d, reach, params.approach, 2.0 * params.acc_max
    return replace(whole, pairs=broad_phase(whole.pos, whole.vel, (ways, whole.growth), limits))


def _ways_to_rest(scene: Traffic, params: SafeReplannerParams) -> tuple[Array, float]:
    """Return the stopping distance of each row with growth [m], (rows,), and the largest speed [m/s]."""
    fast = np.sqrt((scene.vel**2).sum(-1)) + params.acc_max * params.hold
    top, rate = float(fast.max()), 2.0 * float(scene.growth[:, 1].max())
    rest = params.hold + (top + rate) / params.acc_max
    way = fast * (params.hold + 0.5 * fast / params.acc_max)
    return way + scene.growth[:, 0] + scene.growth[:, 1] * rest, top
