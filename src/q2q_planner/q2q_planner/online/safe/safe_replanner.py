"""Online replanner that keeps pairs out of each other's zone, with a promise, and reports when it is broken.

**Promise.** While a vehicle's status is not PROMISE_BROKEN, its modified trajectory stays, at all times, out
of the zone I(eps, d) of every other trajectory of the swarm and of every external vehicle; so does a vehicle
that follows its modified trajectory within `tracking`. A trajectory exceeds `acc_max` only where it equals
the reference.

With `tracking_z` the tolerance is a tube, `tracking` wide and `tracking_z` high: the zone and both tubes are
kept apart. With `jerk_max` every modified trajectory has bounded jerk and acceleration on every axis,
whatever the reference does: one that exceeds `jerk_max`, `acc_max` or `speed_max` is left at that tick.

**Conditions.** The promise is broken, and reported at the same tick, if
1. at the first tick, or when a vehicle appears, two can no longer brake outside their zone;
2. a vehicle is measured further from its modified trajectory than `tracking`, plus `drift` times the age of
   the measurement and the change of course possible since: the vehicle, not the trajectory, breaks it;
3. an external vehicle (one of `state` without a setpoint here) does what no vehicle under this law does:
   accelerate beyond `acc_max`, exceed `speed_max`, or fly on when it should brake; or its last known state is
   older than `forget`;
4. with `jerk_max`: a modified trajectory is faster than `speed_max`, for which no tube is known, or a vehicle
   comes near an external one, whose acceleration nobody sends.
The reference is arbitrary; it is followed as far as the promise allows, and bit for bit where nothing is
near.

**Proof.** At each tick every vehicle has a motion: an acceleration held for `hold`, then braking to rest
(`braking`), or with `jerk_max` a jerk held for `hold`, then the fastest stop (`jerk_limited`). All pairs of
motions are proven to stay apart for all time. A vehicle whose new motion fails against any other continues
the motion of the previous tick, which was proven and whose rest remains proven against all that do the same;
so a proven choice always exists. Lost ticks only lead further along a proven motion. Of an external vehicle
only an older state is known: since then its velocity may have changed by acc_max times the age, so its zone
grows by 1/2 acc_max age^2, and further at acc_max age per second. Two replanners with delayed messages of
each other thus keep the promise together: at every tick each proves its motion against every motion the other
may have chosen at that tick, and any other choice is the rest of a motion proven before.

**Control law.** The tracking law of (20), corrected by control barriers (`barrier`): e'' = -k_d e' - k_p e
and the least push along the zone's normal that keeps the pair's approach stoppable. With `jerk_max` the
acceleration approaches it with the time constant LAG.
"""

from dataclasses import replace

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.signals.repeated_stamp import is_repeated
from q2q_model.signals.values import Array, Names, SetpointStatus, SwarmSetpoint, SwarmState, index_of
from q2q_planner.online.safe.barrier import BarrierLaw, BarrierStates, push_apart
from q2q_planner.online.safe.braking import BrakingLaw, Motions
from q2q_planner.online.safe.committed_motion import CommittedMotion, Mask, propagated
from q2q_planner.online.safe.jerk_limited import jerk_towards
from q2q_planner.online.safe.last_known_states import LastKnownStates
from q2q_planner.online.safe.motion_choice import (
    BROKEN,
    NEW,
    OLD,
    ChoiceRule,
    Choices,
    Proven,
    choose_motions,
)
from q2q_planner.online.safe.safe_replanner_params import SafeReplannerParams
from q2q_planner.online.safe.traffic import TrafficTable, off_trajectory, own_uncertainty, traffic_at
from q2q_planner.online.setpoint_error import SHIFT_TOLERANCE

FLOOR = 1e-3
"""Distance that a new motion keeps from the zone, added to all growth [m]."""
LAG = 0.05
"""Time constant at which the acceleration approaches the wanted one where jerk is bounded [s]."""
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
        self._committed: CommittedMotion | None = None
        self._answer: SwarmSetpoint | None = None
        self._last_known.reset()
        self._known: tuple[Names, Names] = ((), ())
        self._proven: Proven = np.zeros((0, 0), np.bool_)

    def configure(self, params: SafeReplannerParams) -> None:
        """Change the parameters in flight; the modified trajectories continue without a jump."""
        self.params = params

    def update(self, setpoint: SwarmSetpoint, state: SwarmState | None) -> SwarmSetpoint:
        """Return the modified setpoints of the tick.

        A repeated stamp returns the same setpoints; one that goes back, of a late frame or a clock set
        back, leaves the motions where they are; a gap over LONGEST_GAP either way restarts on the
        reference. `state` None assumes ideal tracking and no external vehicles.
        """
        if is_repeated(self._answer, setpoint.t, setpoint.names):
            return self._answer
        if state is not None:
            self._last_known.update(state)
        params, names = self.params.with_tube, setpoint.names
        committed = propagated(self._committed, setpoint, params.acc_max, params.jerk_max)
        known = None if state is None else self._last_known.of(names, setpoint.t)
        growth = own_uncertainty(committed, known, params)
        external = self._last_known.external(names, setpoint.t, params.forget)
        committed, traffic = traffic_at(committed, setpoint, growth, external, params)
        desired, pushed = _desired(committed, setpoint, traffic, params)
        new = _new_motion(committed, setpoint, desired, params)
        self._recognise(names, external.names)
        choice = _choice(committed, traffic, new, self._proven, params)
        self._committed = _decided(committed, new, choice, pushed)
        off = off_trajectory(committed, known, self.params)
        broken = ((choice == BROKEN) | off | _outside(self._committed, traffic, params)) & params.enabled
        self._answer = _answer(setpoint, self._committed, broken, _acceleration(self._committed, params))
        return self._answer

    def _recognise(self, own: Names, external: Names) -> None:
        """Match the proven pairs to this tick's names; a new vehicle is in none."""
        if self._known == (own, external):
            return
        rows, columns = index_of(own, self._known[0]), index_of(external, self._known[1])
        proven = np.zeros((len(own), len(external)), np.bool_)
        both = np.ix_(rows >= 0, columns >= 0)
        proven[both] = self._proven[np.ix_(rows[rows >= 0], columns[columns >= 0])]
        self._known, self._proven = (own, external), proven


def _desired(
    committed: CommittedMotion, setpoint: SwarmSetpoint, traffic: TrafficTable, params: SafeReplannerParams
) -> tuple[Array, Mask]:
    """Return the swarm's wanted accelerations (n, 3), and which vehicles the barrier changed (n,)."""
    pull = -params.k_d * (committed.vel - setpoint.vel) - params.k_p * (committed.pos - setpoint.pos)
    back = _limited(setpoint.acc + pull, params.acc_max)
    acc = np.where(committed.on_reference[:, None], setpoint.acc, back)
    if not (params.enabled and len(traffic.pairs.i)):
        return acc, np.zeros(traffic.own, np.bool_)
    turned = np.zeros((len(traffic.pos), 3))
    turned[: traffic.own] = np.where(traffic.meets[:, None], _limited(acc, params.acc_max), acc)
    wide = traffic.growth[traffic.pairs.i] + traffic.growth[traffic.pairs.j]
    wide[:, 0] += params.margin + FLOOR
    reference = np.concatenate([setpoint.pos, traffic.pos[traffic.own :]])
    poles = 2.0 * params.approach, params.approach**2
    law = BarrierLaw(traffic.own, params.eps, params.d, *poles, params.around, params.height)
    states = BarrierStates(traffic.pos, traffic.vel, reference)
    pushed = push_apart(turned, states, traffic.pairs, wide, law)[: traffic.own]
    limited = np.where(
        pushed[:, None], _limited(turned[: traffic.own], params.acc_max), turned[: traffic.own]
    )
    return limited, pushed | (limited != acc).any(axis=1)


def _new_motion(
    committed: CommittedMotion, setpoint: SwarmSetpoint, desired: Array, params: SafeReplannerParams
) -> CommittedMotion:
    """Return the motion with wanted accelerations (n, 3), from the reference's acceleration where on it."""
    hold = np.full(len(committed.names), params.hold)
    if params.jerk_max == 0.0:
        return replace(committed, acc=desired, hold=hold)
    acc = np.where(committed.on_reference[:, None], setpoint.acc, committed.acc)
    return replace(committed, acc=acc, hold=hold, jerk=jerk_towards(desired, acc, LAG, params.jerk_max))


def _choice(
    committed: CommittedMotion,
    traffic: TrafficTable,
    new: CommittedMotion,
    proven: Proven,
    params: SafeReplannerParams,
) -> Choices:
    """Return the choice of each vehicle of the swarm, (n,); `proven` is updated in place."""
    if not (params.enabled and len(traffic.pairs.i)):
        return np.full(traffic.own, NEW, dtype=np.int8)
    own, still = traffic.own, np.zeros_like(traffic.pos[traffic.own :])
    acc, jerk = np.concatenate([new.acc, still]), np.concatenate([new.jerk, still])
    hold = np.full(len(acc), params.hold)
    fresh = Motions(traffic.pos, traffic.vel, acc, hold, traffic.growth, jerk)
    certain = traffic.growth[:own] * np.array([1.0, 0.0])  # a proven motion needs no growth rate
    going = committed.pos, committed.vel, committed.acc, committed.hold, certain, committed.jerk
    old = Motions(*(np.concatenate(both) for both in zip(going, traffic.certain, strict=True)))
    law = BrakingLaw(params.eps, params.d, params.acc_max, params.jerk_max)
    rule = ChoiceRule(law, FLOOR, round(committed.t / TURN))
    return choose_motions(fresh, old, traffic.pairs, proven, rule)[:own]


@compiled
def _limited(acc: Array, most: float) -> Array:
    """Return accelerations (n, 3) clipped to the norm `most` [m/s^2]."""
    short = acc.copy()
    for row in range(len(acc)):
        size = np.sqrt(acc[row, 0] ** 2 + acc[row, 1] ** 2 + acc[row, 2] ** 2)
        if size > most:
            short[row] *= most / size
    return short


def _decided(
    committed: CommittedMotion, new: CommittedMotion, choice: Choices, pushed: Mask
) -> CommittedMotion:
    """Return the motion that the swarm commits to."""
    fresh = choice != OLD
    return replace(
        committed,
        acc=np.where(fresh[:, None], new.acc, committed.acc),
        hold=np.where(fresh, new.hold, committed.hold),
        jerk=np.where(fresh[:, None], new.jerk, committed.jerk),
        on_reference=committed.on_reference & fresh & ~pushed,
        pushed=pushed | ~fresh,
    )


def _outside(committed: CommittedMotion, traffic: TrafficTable, params: SafeReplannerParams) -> Mask:
    """Return which vehicles of bounded jerk are too fast, or near an external vehicle, (n,)."""
    if params.jerk_max == 0.0:
        return np.zeros(traffic.own, np.bool_)
    outside: Mask = np.sqrt((committed.vel**2).sum(-1)) > params.speed_max
    outside[traffic.pairs.i[traffic.pairs.j >= traffic.own]] = True
    return outside


def _acceleration(committed: CommittedMotion, params: SafeReplannerParams) -> Array:
    """Return the acceleration of the motion at its time [m/s^2], (n, 3)."""
    if params.jerk_max > 0.0:
        return committed.acc
    speed = np.sqrt((committed.vel**2).sum(-1, keepdims=True))
    stopping = -params.acc_max * committed.vel / np.where(speed > 0.0, speed, 1.0)
    return np.where((committed.hold > 0.0)[:, None], committed.acc, stopping)


def _answer(setpoint: SwarmSetpoint, committed: CommittedMotion, broken: Mask, acc: Array) -> SwarmSetpoint:
    """Return the setpoint of the tick; the reference object itself if no vehicle deviates from it."""
    if committed.on_reference.all() and not broken.any():
        return setpoint
    moved = np.sqrt(((committed.pos - setpoint.pos) ** 2).sum(-1)) > SHIFT_TOLERANCE
    status = np.where(moved, np.uint8(SetpointStatus.SHIFTED), setpoint.status)
    status = np.where(broken, np.uint8(SetpointStatus.PROMISE_BROKEN), status).astype(np.uint8)
    return replace(setpoint, pos=committed.pos, vel=committed.vel, acc=acc, status=status)
