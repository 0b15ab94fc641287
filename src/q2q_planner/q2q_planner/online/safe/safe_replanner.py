"""Online replanner that keeps pairs out of each other's zone, with a promise, and reports when it is broken.

**Promise.** While a vehicle's status is not PROMISE_BROKEN, its modified trajectory stays, at all times, out
of the zone I(eps, d) of every other trajectory of the swarm and of every external vehicle; so does a vehicle
that follows its modified trajectory within `tracking`. A trajectory exceeds `acc_max` only where it equals
the reference.

**Conditions.** The promise is broken, and reported at the same tick, if
1. at the first tick, or when a vehicle appears, two can no longer brake outside their zone;
2. a vehicle is measured further from its modified trajectory than `tracking`, plus `drift` times the age of
   the measurement and the change of course possible since: the vehicle, not the trajectory, breaks it;
3. an external vehicle (one of `state` without a setpoint here) does what no vehicle under this law does:
   accelerate beyond `acc_max`, exceed `speed_max`, or fly on when it should brake; or its last known state is
   older than `forget`.
The reference is arbitrary; it is followed as far as the promise allows, and bit for bit where nothing is
near.

**Proof.** At each tick every vehicle has a motion: an acceleration held for `hold`, then braking to rest
(`braking`). All pairs of motions are proven to stay apart for all time. A vehicle whose new motion fails
against any other continues the motion of the previous tick, which was proven and whose rest remains proven
against all that do the same; so a proven choice always exists. Lost ticks only lead further along a proven
motion. Of an external vehicle only an older state is known: since then its velocity may have changed by
acc_max times the age, so its zone grows by 1/2 acc_max age^2, and further at acc_max age per second. Two
replanners with delayed messages of each other thus keep the promise together: at every tick each proves its
motion against every motion the other may have chosen at that tick, and any other choice is the rest of a
motion proven before.

**Control law.** The tracking law of (20), corrected by control barriers (`barrier`): e'' = -k_d e' - k_p e
and the least push along the zone's normal that keeps the pair's approach stoppable.
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
"""Distance that a new motion keeps from the zone, added to all growth [m]."""
TURN = 0.01
"""Time for which the same vehicle of a pair yields first [s]: one tick."""


class SafeReplanner:
    """Safe replanner, with the committed motion of its swarm."""

    def __init__(self, params: SafeReplannerParams | None = None) -> None:
        """Start on the reference."""
        self.params = params or SafeReplannerParams()
        self._last_known = LastKnownStates()
        self.reset()

    def reset(self) -> None:
        """Forget the modified trajectories and external vehicles; the next update starts on the reference."""
        self._held: CommittedMotion | None = None
        self._answer: SwarmSetpoint | None = None
        self._last_known.reset()
        self._known: tuple[Names, Names] = ((), ())
        self._proven: Proven = np.zeros((0, 0), np.bool_)

    def configure(self, params: SafeReplannerParams) -> None:
        """Change the parameters in flight; the modified trajectories continue without a jump."""
        self.params = params

    def update(self, setpoint: SwarmSetpoint, state: SwarmState | None) -> SwarmSetpoint:
        """Return the modified setpoints of the tick.

        A repeated stamp returns the same setpoints; a stamp that goes back, or a gap over LONGEST_GAP,
        restarts on the reference. `state` None assumes ideal tracking and no external vehicles.
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
        """Match the proven pairs to this tick's names; a new vehicle is in none."""
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
    """Return the swarm's wanted accelerations (n, 3), and which vehicles the barrier changed (n,)."""
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
    """Return the choice of each vehicle of the swarm, (n,); `proven` is updated in place."""
    if not (params.enabled and len(scene.pairs[0])):
        return np.full(scene.own, NEW, dtype=np.int8)
    own, acc = scene.own, np.zeros_like(scene.pos)
    acc[:own] = wanted
    new: Motions = (scene.pos, scene.vel, acc, np.full(len(acc), params.hold), scene.growth)
    certain = scene.growth[:own] * np.array([1.0, 0.0])  # a proven motion needs no growth rate
    going = held.pos, held.vel, held.acc, held.hold, certain
    pos, vel, push, hold, growth = (np.concatenate(both) for both in zip(going, scene.sure, strict=True))
    limits = params.eps, params.d, params.acc_max, FLOOR, round(held.t / TURN)
    return choose_motions(new, (pos, vel, push, hold, growth), scene.pairs, proven, limits)[:own]


def _shorten(acc: Array, most: float) -> Array:
    """Return accelerations (n, 3) clipped to the norm `most` [m/s^2]."""
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
    """Return the motion that the swarm commits to."""
    fresh = choice != OLD
    return replace(
        held,
        acc=np.where(fresh[:, None], wanted, held.acc),
        hold=np.where(fresh, hold, held.hold),
        on_reference=held.on_reference & fresh & ~pushed,
        pushed=pushed | ~fresh,
    )


def _answer(setpoint: SwarmSetpoint, held: CommittedMotion, broken: Mask, brake: float) -> SwarmSetpoint:
    """Return the setpoint of the tick; the reference object itself if no vehicle deviates from it."""
    if held.on_reference.all() and not broken.any():
        return setpoint
    speed = np.sqrt((held.vel**2).sum(-1, keepdims=True))
    stopping = -brake * held.vel / np.where(speed > 0.0, speed, 1.0)
    acc = np.where((held.hold > 0.0)[:, None], held.acc, stopping)
    moved = np.sqrt(((held.pos - setpoint.pos) ** 2).sum(-1)) > SHIFT_TOLERANCE
    status = np.where(moved, np.uint8(SetpointStatus.SHIFTED), setpoint.status)
    status = np.where(broken, np.uint8(SetpointStatus.PROMISE_BROKEN), status).astype(np.uint8)
    return replace(setpoint, pos=held.pos, vel=held.vel, acc=acc, status=status)
