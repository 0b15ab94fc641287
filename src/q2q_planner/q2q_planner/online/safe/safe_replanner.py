"""Online replanner that keeps pairs out of each other's zone, with a promise, and reports when it is broken.

**Promise.** While a vehicle's status is not PROMISE_BROKEN, its modified trajectory stays, at all times, out
of the zone I(eps, d) of every other trajectory of the swarm and of every external vehicle; so does a vehicle
that follows its modified trajectory within `tracking`. A trajectory exceeds `acc_max` only where it equals
the reference, and for `hold` at most after that. None is led lower than `height_min` or its reference.

With `tracking_z` the tolerance is a tube, `tracking` wide and `tracking_z` high: the zone and both tubes are
kept apart. With `jerk_max` every modified trajectory has bounded jerk and acceleration on every axis,
whatever the reference does: one that exceeds `jerk_max` or `acc_max`, or accelerates too much to stay below
`speed_max`, is left at that tick.

**Conditions.** The promise is broken, and reported at the same tick, if
1. at the first tick, or when a vehicle appears, is measured again or far from its modified trajectory
   (`lost_vehicles`), two can no longer brake outside their zone;
2. a vehicle is measured further from its modified trajectory than `tracking`, plus `drift` times the age of
   the measurement and the change of course possible since: the vehicle, not the trajectory, breaks it. Or
   it was not measured for `forget`, from its first tick on if it never was;
3. an external vehicle (one of `state` without a setpoint here) does what no vehicle under this law does:
   accelerate beyond `acc_max`, exceed `speed_max`, or fly on when it should brake. This is not measured:
   vehicles near it report it once its state leaves no motion that is proven. Or its last known state is older
   than `forget`: all vehicles report it in that tick, and nothing is promised about it from then on until it
   is received again;
4. with `jerk_max`: a modified trajectory is faster than `speed_max`, for which no tube is known, or a vehicle
   comes near an external one, whose acceleration nobody sends;
5. a setpoint of the reference is not finite (`nonfinite_setpoints`).
Otherwise the reference is arbitrary; it is followed as far as the promise allows, and bit for bit where
nothing is near.

**Proof.** At each tick every vehicle has a motion: an acceleration held for `hold`, then braking to rest
(`braking`), or with `jerk_max` a jerk held for `hold`, then the fastest stop (`jerk_limited`). All pairs of
motions are proven to stay apart for all time, or cannot reach each other (`broad_phase`). A vehicle whose new
motion fails against any other continues the motion of the previous tick, which was proven and whose rest
remains proven against all that do the same; so a proven choice always exists. Lost ticks only lead further
along a proven motion. Of an external vehicle only an older state is known: since then its velocity may have
changed by acc_max times the age, so its zone grows by 1/2 acc_max age^2, and further at acc_max age per
second. Two replanners with delayed messages of each other thus keep the promise together: at every tick each
proves its motion against every motion the other may have chosen at that tick, and any other choice is the
rest of a motion proven before.

**Control law.** The tracking law of (20), corrected by control barriers (`barrier`): e'' = -k_d e' - k_p e
and the least correction along the zone's normal that keeps the pair's approach stoppable (`desired_motion`).
"""

from dataclasses import replace

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.signals.repeated_stamp import StampOrder, is_repeated
from q2q_model.signals.stamps import TICK_S
from q2q_model.signals.values import (
    PROMISE_BROKEN,
    SHIFTED,
    Array,
    Mask,
    Names,
    Status,
    SwarmSetpoint,
    SwarmState,
    index_of,
)
from q2q_planner.online.last_known_states import KnownStates, LastKnownStates
from q2q_planner.online.replanner import LONGEST_GAP
from q2q_planner.online.safe.choice.candidate_motions import PairedTraffic
from q2q_planner.online.safe.choice.decision import decide
from q2q_planner.online.safe.choice.desired_motion import DesiredMotion, desired_motion
from q2q_planner.online.safe.choice.motion_choice import (
    BROKEN,
    ChoiceRule,
    Choices,
    Proven,
    choice_rule,
    choices_alone,
    choices_at,
)
from q2q_planner.online.safe.lost_vehicles import LostVehicles, far_from_motion, restart_motion, tracked_now
from q2q_planner.online.safe.motion.committed_motion import CommittedMotion, still_flown
from q2q_planner.online.safe.motion.followed_reference import ReferenceRows, reference_rows
from q2q_planner.online.safe.motion.motion_propagation import propagate
from q2q_planner.online.safe.motion.safe_replanner_params import SafeReplannerParams
from q2q_planner.online.safe.motion.traffic import TrafficTable, traffic_at
from q2q_planner.online.safe.motion.vectors import distance
from q2q_planner.online.safe.nonfinite_setpoints import (
    flyable_inputs,
    is_flyable,
    off_reference,
    output_for_all,
)
from q2q_planner.online.safe.tracking_uncertainty import off_trajectory, own_uncertainty
from q2q_planner.online.setpoint_error import SHIFT_TOLERANCE


class SafeReplanner:
    """Safe replanner, with the committed motion of its swarm."""

    def __init__(self, params: SafeReplannerParams | None = None) -> None:
        """Start on the reference."""
        self.configure(params or SafeReplannerParams())
        self._last_known = LastKnownStates()
        self._order = StampOrder()
        self.reset()

    def reset(self) -> None:
        """Forget the modified trajectories and external vehicles; the next update starts as the first did."""
        self._committed: CommittedMotion | None = None
        self._output: SwarmSetpoint | None = None
        self._turn = 0
        self._last_known.reset()
        self._order.reset()
        self._lost = LostVehicles()
        self._forget_proofs()

    def _forget_proofs(self) -> None:
        self._known: tuple[Names, Names] = ((), ())
        self._proven: Proven = np.zeros((0, 0), np.bool_)

    def configure(self, params: SafeReplannerParams) -> None:
        """Change the parameters in flight; the modified trajectories continue without a jump.

        What was proven against external vehicles is proven again: the zone or their bounds may have changed.
        """
        self.params, self._grown = params, params.with_tube
        self._forget_proofs()

    def update(self, setpoint: SwarmSetpoint, state: SwarmState | None) -> SwarmSetpoint:
        """Return the modified setpoints of the tick.

        The first ones start on the reference; where a vehicle is tracked off it, where that is measured.
        A repeated stamp returns the same setpoints, and a late one the newest, under its own stamp. Where
        the clock is set back motions go on in the new time (StampOrder); after a gap over LONGEST_GAP either
        way vehicles start as at the first tick. `state` None assumes ideal tracking and no external vehicles.
        """
        last = self._output
        if is_repeated(last, setpoint.t, setpoint.names):
            return last
        if self._order.reject_stamp(setpoint.t) and last is not None:
            return output_for_all(setpoint, last)
        if self._order.set_back > 0.0:
            self._set_back(self._order.set_back)
        if state is not None:
            self._last_known.update(state)
        reference = reference_rows(setpoint)
        if is_flyable(setpoint, reference, self._committed):
            self._output = self._tick(setpoint, reference, state)
            return self._output
        some = flyable_inputs(setpoint, self._committed, self._output)
        self._committed = some.committed
        output = self._tick(some.setpoint, reference_rows(some.setpoint), state)
        self._committed = off_reference(self._committed, setpoint)
        self._output = output_for_all(setpoint, output)
        return self._output

    def _set_back(self, by: float) -> None:
        """Go on in the time of a clock that was set back [s]; motions, if not for too long."""
        self._last_known.set_back(by)
        self._lost.set_back(by)
        if self._committed is not None and by <= LONGEST_GAP:
            self._committed = replace(self._committed, t=self._committed.t - by)

    def _tick(
        self, setpoint: SwarmSetpoint, reference: ReferenceRows, state: SwarmState | None
    ) -> SwarmSetpoint:
        """Return the modified setpoints of finite ones."""
        params, names = self._grown, setpoint.names
        self._committed = still_flown(self._committed, setpoint.t)
        self._turn = round(setpoint.t / TICK_S) if self._committed is None else self._turn + 1
        committed = propagate(self._committed, setpoint, params)
        known = None if state is None else self._last_known.of(names, setpoint.t)
        if state is not None and known is not None:
            committed = self._with_found(committed, known, state)
        growth = own_uncertainty(committed, known, params)
        outdated = not set(self._last_known.forget(setpoint.t, params.forget)).issubset(names)
        external = self._last_known.external(names, setpoint.t)
        committed, traffic = traffic_at(committed, reference, growth, external, params)
        desired = desired_motion(committed, reference, traffic, params)
        self._recognise(names, external.names)
        choice = _choice(committed, traffic, desired, self._proven, choice_rule(params, self._turn))
        self._committed, decision = decide(committed, desired, choice, traffic.pairs, params)
        off = off_trajectory(committed, known, self.params)
        broken = (choice == BROKEN) | off | decision.outside | outdated
        if known is not None:
            broken |= self._lost.forgotten(setpoint.t, params.forget)
        return _output(setpoint, self._committed, broken & params.enabled, decision.acc)

    def _with_found(
        self, committed: CommittedMotion, known: KnownStates, state: SwarmState
    ) -> CommittedMotion:
        """Return the motion in which vehicles that are off it, found again or far, start where they are."""
        found = self._lost.found(known, committed.t)
        if self._committed is None and self.params.enabled:  # it may have been started again in flight
            found |= tracked_now(state, known.names)
        if found.any():
            found &= off_trajectory(committed, known, self.params)
        return restart_motion(committed, known, found | far_from_motion(committed, known), self.params)

    def _recognise(self, own: Names, external: Names) -> None:
        """Match the proven pairs to this tick's names; a new vehicle is in none."""
        if self._known == (own, external):
            return
        rows, columns = index_of(own, self._known[0]), index_of(external, self._known[1])
        proven = np.zeros((len(own), len(external)), np.bool_)
        both = np.ix_(rows >= 0, columns >= 0)
        proven[both] = self._proven[np.ix_(rows[rows >= 0], columns[columns >= 0])]
        self._known, self._proven = (own, external), proven


def _choice(
    committed: CommittedMotion,
    traffic: TrafficTable,
    desired: DesiredMotion,
    proven: Proven,
    rule: ChoiceRule | None,
) -> Choices:
    """Return the choice of each vehicle of the swarm, (n,); `proven` is updated in place."""
    if rule is None or not len(traffic.pairs.i):
        return choices_alone(desired.kind)
    whole = PairedTraffic(traffic.rows, traffic.pairs, traffic.certain)
    return choices_at(committed.rows, desired, whole, proven, rule)


def _output(setpoint: SwarmSetpoint, committed: CommittedMotion, broken: Mask, acc: Array) -> SwarmSetpoint:
    """Return the setpoint of the tick; the reference object itself if no vehicle deviates from it."""
    status, rows = setpoint.status.copy(), committed.rows
    if not _marked(status, rows.pos, np.array(setpoint.pos), rows.on_reference, broken):
        return setpoint
    return SwarmSetpoint(
        setpoint.t,
        setpoint.names,
        rows.pos,
        rows.vel,
        acc,
        setpoint.yaw,
        setpoint.yaw_rate,
        status,
    )


@compiled
def _marked(status: Status, pos: Array, reference: Array, on_reference: Mask, broken: Mask) -> bool:
    """Mark in `status`, (n,), who is shifted and who broke the promise; return whether any deviates."""
    deviates = False
    for row in range(status.size):
        deviates |= broken[row] or not on_reference[row]
        if broken[row]:
            status[row] = PROMISE_BROKEN
        elif distance(pos, reference, row) > SHIFT_TOLERANCE:
            status[row] = SHIFTED
    return deviates
