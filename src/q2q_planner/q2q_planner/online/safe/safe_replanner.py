"""Move setpoints so that pairs keep out of each other's zone, with a promise, and say when it cannot hold.

**The promise.** Between the ticks at which it says so, no modified trajectory of this swarm comes into the
zone I(eps, d) of another one, or of a stranger, at any time; nor does any vehicle that follows its modified
trajectory within `tracking`. A trajectory accelerates by more than `acc_max` only where it is the reference.

**Its conditions.** A vehicle whose status is not PROMISE_BROKEN is under the promise. It is broken, and
said to be at that very tick, where
1. at the first tick, or when a vehicle or stranger appears, two could not brake outside their zone any more;
2. a vehicle is measured further than `tracking` from its modified trajectory, plus `drift` times the age of
   the measurement and what it may have turned since: then the vehicle, not the trajectory, breaks it;
3. a stranger (a vehicle of `state` that has no setpoint here) does what no vehicle under this law would do:
   accelerate beyond `acc_max`, exceed `speed_max`, or move on when it should brake; or is not heard of for
   longer than `forget`.
A reference may do anything; it is followed as far as the promise allows, and exactly, to the last bit,
where nothing is near.

**Why it holds.** Each tick every vehicle has a motion: an acceleration held for `hold`, then braking to
rest (`braking`). All pairs of motions are proven to keep out, for all time. A vehicle whose new motion
fails against anyone goes on with the motion of the tick before, which was proven, and whose rest is still
proven against all that do the same; so there is always a proven choice. Lost ticks only lead further along
a proven motion. Of a stranger only the state at an older stamp is known: in the time since it may have
changed its velocity by acc_max times the age, so its zone grows by 1/2 acc_max age^2 and, at acc_max age a
second, further ahead. Two replanners that meet each other so, each with delayed messages of the other,
keep the promise together: at every tick each proves its motion against everything the other may have
chosen at that tick, and every other choice is the rest of a motion proven before.

**What it wants.** The tracking law of (20) turned by control barriers (`barrier`): e'' = -k_d e' - k_p e and
the least push that keeps the pair's approach stoppable, sideways along the zone's normal.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array, Names, SetpointStatus, SwarmSetpoint, SwarmState, index_of
from q2q_planner.online.safe.barrier import push_apart
from q2q_planner.online.safe.braking import Motions
from q2q_planner.online.safe.committed_motion import CommittedMotion, Mask, carried_on
from q2q_planner.online.safe.last_known_states import LastKnownStates
from q2q_planner.online.safe.motion_choice import BROKEN, NEW, OLD, Choices, Proven, choose_motions
from q2q_planner.online.safe.safe_replanner_params import SafeReplannerParams
from q2q_planner.online.safe.traffic import Traffic, astray, own_uncertainty, scene_of
from q2q_planner.online.setpoint_error import SHIFT_TOLERANCE

FLOOR = 1e-3
"""Distance that a new motion keeps from the zone beside all growth [m]."""


TURN = 0.01
"""How long it is one vehicle's turn to yield, before the other's [s]: a tick."""


class SafeReplanner:
    """Replanner that keeps the promise above."""

    def __init__(self, params: SafeReplannerParams | None = None) -> None:
        """Start on the reference."""
        self.params = params or SafeReplannerParams()
        self._last_known = LastKnownStates()
        self.reset()

    def reset(self) -> None:
        """Forget the modified trajectories and all strangers; the next update starts on the reference."""
        self._held: CommittedMotion | None = None
        self._answer: SwarmSetpoint | None = None
        self._last_known.reset()
        self._known: tuple[Names, Names] = ((), ())
        self._proven: Proven = np.zeros((0, 0), np.bool_)

    def configure(self, params: SafeReplannerParams) -> None:
        """Take other parameters in flight; the modified trajectories go on without a jump."""
        self.params = params

    def update(self, setpoint: SwarmSetpoint, state: SwarmState | None) -> SwarmSetpoint:
        """Return the modified setpoints of the tick.

        A repeated stamp gets the same answer; a stamp that goes back, or a gap over LONGEST_GAP, starts
        on the reference again. `state` None trusts every vehicle to follow and knows of no strangers.
        """
        if self._answer is not None and setpoint.t == self._answer.t:
            return self._answer
        if state is not None:
            self._last_known.hear(state)
        params, names = self.params, setpoint.names
        held = carried_on(self._held, setpoint, params.acc_max)
        seen = None if state is None else self._last_known.of(names, setpoint.t)
        growth = own_uncertainty(held, seen, params)
        strangers = self._last_known.strangers(names, setpoint.t, params.forget)
        held, scene = scene_of(held, setpoint, growth, strangers, params)
        wanted, pushed = _wanted(held, setpoint, scene, params)
        self._recognise(names, strangers.names)
        choice = _choice(held, scene, wanted, self._proven, params)
        self._held = _decided(held, wanted, choice, pushed, params.hold)
        broken = ((choice == BROKEN) | astray(held, seen, params)) & params.enabled
        self._answer = _answer(setpoint, self._held, broken, params.acc_max)
        return self._answer

    def _recognise(self, own: Names, strangers: Names) -> None:
        """Line up what is proven of pairs with this tick's names; who is new has proven nothing."""
        if self._known == (own, strangers):
            return
        rows, columns = index_of(own, self._known[0]), index_of(strangers, self._known[1])
        proven = np.zeros((len(own), len(strangers)), np.bool_)
        both = np.ix_(rows >= 0, columns >= 0)
        proven[both] = self._proven[np.ix_(rows[rows >= 0], columns[columns >= 0])]
        self._known, self._proven = (own, strangers), proven


def _wanted(
    held: CommittedMotion, setpoint: SwarmSetpoint, scene: Traffic, params: SafeReplannerParams
) -> tuple[Array, Mask]:
    """Return the accelerations wanted by the swarm (n, 3), and who was turned from its own (n,)."""
    pull = -params.k_d * (held.vel - setpoint.vel) - params.k_p * (held.pos - setpoint.pos)
    back = _limited(setpoint.acc + pull, params.acc_max)
    acc = np.where(held.on_reference[:, None], setpoint.acc, back)
    if not (params.enabled and len(scene.pairs[0])):
        return acc, np.zeros(scene.own, np.bool_)
    turned = np.zeros((len(scene.pos), 3))
    turned[: scene.own] = np.where(scene.meets[:, None], _limited(acc, params.acc_max), acc)
    wide = scene.growth[scene.pairs[0]] + scene.growth[scene.pairs[1]]
    wide[:, 0] += params.margin + FLOOR
    reference = np.concatenate([setpoint.pos, scene.pos[scene.own :]])
    poles = 2.0 * params.approach, params.approach**2
    law = scene.own, params.eps, params.d, *poles, params.around, params.height
    pushed = push_apart(turned, (scene.pos, scene.vel, reference), scene.pairs, wide, law)[: scene.own]
    limited = np.where(pushed[:, None], _limited(turned[: scene.own], params.acc_max), turned[: scene.own])
    return limited, pushed | (limited != acc).any(axis=1)


def _choice(
    held: CommittedMotion, scene: Traffic, wanted: Array, proven: Proven, params: SafeReplannerParams
) -> Choices:
    """Return what each vehicle of the swarm does, (n,); `proven` is kept up in place."""
    if not (params.enabled and len(scene.pairs[0])):
        return np.full(scene.own, NEW, dtype=np.int8)
    own, acc = scene.own, np.zeros_like(scene.pos)
    acc[:own] = wanted
    new: Motions = (scene.pos, scene.vel, acc, np.full(len(acc), params.hold), scene.growth)
    certain = scene.growth[:own] * np.array([1.0, 0.0])  # what was proven needs no look ahead
    going = held.pos, held.vel, held.acc, held.hold, certain
    pos, vel, push, hold, growth = (np.concatenate(both) for both in zip(going, scene.sure, strict=True))
    limits = params.eps, params.d, params.acc_max, FLOOR, round(held.t / TURN)
    return choose_motions(new, (pos, vel, push, hold, growth), scene.pairs, proven, limits)[:own]


def _shorten(acc: Array, most: float) -> Array:
    """Return accelerations (n, 3) shortened to `most` [m/s^2]."""
    short = acc.copy()
    for row in range(len(acc)):
        size = np.sqrt(acc[row, 0] ** 2 + acc[row, 1] ** 2 + acc[row, 2] ** 2)
        if size > most:
            short[row] *= most / size
    return short


_limited: Callable[[Array, float], Array] = compiled(_shorten)


def _decided(
    held: CommittedMotion, wanted: Array, choice: Choices, pushed: Mask, hold: float
) -> CommittedMotion:
    """Return what the swarm does from now on."""
    fresh = choice != OLD
    return replace(
        held,
        acc=np.where(fresh[:, None], wanted, held.acc),
        hold=np.where(fresh, hold, held.hold),
        on_reference=held.on_reference & fresh & ~pushed,
        pushed=pushed | ~fresh,
    )


def _answer(setpoint: SwarmSetpoint, held: CommittedMotion, broken: Mask, brake: float) -> SwarmSetpoint:
    """Return the setpoint of the tick; the reference object itself where nothing is moved."""
    if held.on_reference.all() and not broken.any():
        return setpoint
    speed = np.sqrt((held.vel**2).sum(-1, keepdims=True))
    stopping = -brake * held.vel / np.where(speed > 0.0, speed, 1.0)
    acc = np.where((held.hold > 0.0)[:, None], held.acc, stopping)
    moved = np.sqrt(((held.pos - setpoint.pos) ** 2).sum(-1)) > SHIFT_TOLERANCE
    status = np.where(moved, np.uint8(SetpointStatus.SHIFTED), setpoint.status)
    status = np.where(broken, np.uint8(SetpointStatus.PROMISE_BROKEN), status).astype(np.uint8)
    return replace(setpoint, pos=held.pos, vel=held.vel, acc=acc, status=status)
