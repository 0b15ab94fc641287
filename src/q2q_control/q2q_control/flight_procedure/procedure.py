"""Fly vehicles from the ground to the ground: the state machine of `radio` and of the bridge to Crazyswarm2.

    offline -> connected -> checked -- take_off --> arming -> take-off -> hover
        ^                                         hover, hold -- fly --> glide -> flight -> hold
        +-- disarming <- landing <-- land -- take-off, hover, glide, flight, hold

| step | what happens | done when |
|---|---|---|
| arming | vehicles arm | all have |
| take-off | by their own commanders, to take_off_height | all are there and rest |
| glide | streamed setpoints lead them to the plan's first points, proven apart | all are there |
| flight | the plan's clock runs | the plan is over: hold; or `hold`: brake along the plan |
| landing | stream stopped, then said so, then landed | all rest on the ground, as motion capture sees them |
| disarming | vehicles disarm | they have, or their build arms by itself |
| stopped | after `emergency` | all vehicles were restarted |

Nothing moves without a call. A call that is not granted changes nothing. One that is granted is answered
when what it asked for has happened, has failed, or another call took over: `land` takes over from all but
itself, `hold` from `fly`, `emergency` from all. `start` skips take-off and glide, for vehicles that are at
their setpoints already. In flight, a setpoint that jumps is not flown: all land, as they do when setpoints
stay away. From a hold, `land` first glides back to the plan's first points, where the next flight may begin
(land_home); so it does from anywhere where vehicles overlap, seen from above. `land` once more lands them
where they are.
"""

import numpy as np

from q2q_control.flight_procedure.checks import (
    apart_refusal,
    connection_refusal,
    join_refusal,
    setpoint_refusal,
    state_refusal,
    take_off_refusal,
    unchecked,
)
from q2q_control.flight_procedure.observation import Observation
from q2q_control.flight_procedure.procedure_params import FlightProcedureParams, LandingParams
from q2q_control.flight_procedure.rest import Rest, at_height, at_points, places
from q2q_control.flight_procedure.steps import FLYING, ON_GROUND, Act, Call, Order, Step
from q2q_model.node.reply import Reply
from q2q_model.signals.values import Array

LOOK_S = 1.0
"""How often the checks are made while vehicles wait on the ground [s]."""
HAND_OVER_S = 1.0
"""Longest time from a granted glide to its first setpoint at the vehicles [s]."""

ORDERS_OF = {
    Call.START: (Act.ARM, Act.STREAM),
    Call.TAKE_OFF: (Act.WAIT, Act.ARM, Act.TAKE_OFF),
    Call.FLY: (Act.GLIDE, Act.STREAM, Act.START),
    Call.HOLD: (Act.BRAKE,),
    Call.LAND: (Act.STOP_STREAM, Act.LAND, Act.DISARM),
    Call.EMERGENCY: (Act.CUT,),
}
"""What each call leads to, in this order."""
ALLOWED_IN = {
    Call.START: ON_GROUND,
    Call.TAKE_OFF: ON_GROUND,
    Call.FLY: frozenset({Step.HOVER, Step.HOLD}),
    Call.HOLD: frozenset({Step.GLIDE, Step.FLIGHT}),
    Call.LAND: FLYING | {Step.ARMING, Step.LANDING},
    Call.EMERGENCY: frozenset(Step),
}


class FlightProcedure:
    """Step of a flight, and the call that waits for its answer."""

    def __init__(self, params: FlightProcedureParams, landing: LandingParams) -> None:
        self._params, self._landing = params, landing
        self._rest = Rest(params.settle_s)
        self.step = Step.OFFLINE
        self.refusal = ""
        """Why vehicles on the ground may not take off, when last looked."""
        self.unchecked = ""
        """What could not be checked then, because vehicles do not tell it."""
        self._since = -np.inf
        self._looked = -np.inf
        self._pending: Call | None = None
        self._waiting: Order | None = None
        """The order whose outcome is not known yet."""
        self._asked = -np.inf
        self._streams = self._streamed = False
        self._lands_after_glide = False
        self._joins = False
        self._last_wanted: Array | None = None
        self._fault = ""
        self._orders: list[Order] = []
        self._replies: list[tuple[Call, Reply]] = []
        self._said: list[str] = []

    def call(self, call: Call, seen: Observation, t: float) -> Reply | None:
        """Take a call at time t [s]; return its answer, or None where that comes later (`replies`)."""
        refusal = self._refusal(call, seen)
        if self._params.dry_run:
            acts = ", then ".join(str(self._order(act, seen)) for act in ORDERS_OF[call])
            checks = refusal or unchecked(seen) or "all checks pass"
            words = f"dry run, nothing is sent; {checks}; {call.value} means: {acts}"
            self._said.append(words)
            return Reply(granted=not refusal, reason=words)
        if refusal:
            self._said.append(f"{call.value} refused: {refusal}")
            return Reply(granted=False, reason=refusal)
        self._answer(granted=False, reason=f"{call.value} took over")
        self._pending = call
        self._begin(call, seen, t)
        return None

    def update(self, seen: Observation, outcome: Reply | None, t: float) -> None:
        """Move on at time t [s]; `outcome` is that of the last order, None where it is not known yet."""
        self._guard(seen, t)
        if self._waiting is not None:
            self._conclude(self._waiting, seen, outcome, t)
            return
        follow = {
            Step.TAKE_OFF: self._climb,
            Step.HOVER: self._stay,
            Step.GLIDE: self._glide,
            Step.FLIGHT: self._fly,
            Step.HOLD: self._hold,
            Step.LANDING: self._descend,
            Step.STOPPED: self._stopped,
        }
        follow.get(self.step, self._look)(seen, t)

    def follows(self, wanted: Array) -> bool:
        """Return whether to fly setpoints at these positions (n, 3) [m]; NaN is a vehicle without one."""
        last, self._last_wanted = self._last_wanted, wanted
        if not self._streams or self._fault:
            return False
        moved = 0.0 if last is None else float(np.nan_to_num(_norm(wanted - last)).max(initial=0.0))
        if moved > self._params.jump:
            self._fault = f"a setpoint jumped by {moved:.2f} m: {self._params.jump:.2f} m is the most"
        return not self._fault

    def orders(self) -> tuple[Order, ...]:
        """Return, and forget, what is to be done now."""
        orders, self._orders = tuple(self._orders), []
        return orders

    def replies(self) -> list[tuple[Call, Reply]]:
        """Return, and forget, the answers that calls waited for."""
        replies, self._replies = self._replies, []
        return replies

    def said(self) -> list[str]:
        """Return, and forget, what happened since the last call, a line each."""
        lines, self._said = self._said, []
        return lines

    def _refusal(self, call: Call, seen: Observation) -> str:
        """Return why a call is not granted; empty where it is."""
        if self.step not in ALLOWED_IN[call]:
            allowed = ", ".join(step.value for step in Step if step in ALLOWED_IN[call])
            return f"the step is {self.step.value}: {call.value} is allowed in {allowed}"
        if self._pending is call and call is not Call.EMERGENCY and not self._lands_after_glide:
            return f"{call.value} is under way"
        if call is Call.TAKE_OFF:
            return take_off_refusal(seen, self._params, self._landing)
        if call is Call.START:
            return join_refusal(seen, self._params, self._landing)
        if call is Call.FLY:
            return state_refusal(seen, self._landing) or ("" if seen.plan else "no plan is waiting")
        return ""

    def _begin(self, call: Call, seen: Observation, t: float) -> None:
        again, self._lands_after_glide = self._lands_after_glide, False
        if call is Call.EMERGENCY:
            self._streams = False
            self._enter(Step.STOPPED, t)
            self._give(Act.CUT, seen, t)
        elif call in {Call.TAKE_OFF, Call.START}:
            self._joins = call is Call.START
            self._enter(Step.ARMING, t, unchecked(seen) or "all checks passed")
            self._give(Act.ARM if self._joins else Act.WAIT, seen, t)
        elif call is Call.FLY:
            self._give(Act.GLIDE, seen, t)
        elif call is Call.HOLD:
            self._give(Act.BRAKE, seen, t)
        else:
            self._begin_landing(seen, t, again=again)

    def _begin_landing(self, seen: Observation, t: float, *, again: bool) -> None:
        """Land; from a hold, or where vehicles overlap, after a glide, unless called `again`."""
        if self.step is Step.ARMING:
            self._enter(Step.DISARMING, t)
            self._give(Act.DISARM, seen, t)
            return
        overlap = apart_refusal(seen.names, seen.pos, self._params.apart)
        home = overlap or (self._params.land_home and self.step is Step.HOLD)
        flown = seen.plan is not None and self.step in {Step.GLIDE, Step.FLIGHT, Step.HOLD}
        if home and flown and not again:
            self._said.append(f"{overlap or 'land'}: first a glide to the plan's first points")
            self._lands_after_glide = True
            self._give(Act.GLIDE if self.step is Step.HOLD else Act.BRAKE, seen, t)
            return
        self._land(seen, t)

    def _land(self, seen: Observation, t: float, why: str = "") -> None:
        self._streamed, self._streams = self._streams, False
        self._enter(Step.LANDING, t, why)
        self._give(Act.STOP_STREAM, seen, t)

    def _give(self, act: Act, seen: Observation, t: float) -> None:
        self._waiting, self._asked = self._order(act, seen), t
        self._orders.append(self._waiting)
        self._rest.reset()

    def _order(self, act: Act, seen: Observation) -> Order:
        if act is Act.TAKE_OFF:
            return Order(act, self._params.ground + self._params.take_off_height, self._params.take_off_s)
        if act is Act.LAND:
            height = float(np.nan_to_num(seen.pos[:, 2] - self._params.ground).max(initial=0.0))
            return Order(act, self._params.ground, self._landing.duration(height))
        return Order(act)

    def _conclude(self, order: Order, seen: Observation, outcome: Reply | None, t: float) -> None:
        """Take the outcome of an order; one that does not come in time is a failure."""
        if outcome is None:
            if t - self._asked <= self._params.patience_s:
                return
            outcome = Reply(granted=False, reason=f"{order}: no answer in {self._params.patience_s:g} s")
        self._waiting = None
        if order.act is Act.DISARM:
            self._on_the_ground(seen, outcome, t)
        elif outcome.granted:
            self._succeed(order.act, seen, outcome.reason, t)
        else:
            self._fail(order.act, seen, outcome.reason, t)

    def _succeed(self, act: Act, seen: Observation, reason: str, t: float) -> None:
        if act is Act.WAIT:
            self._give(Act.ARM, seen, t)
        elif act is Act.ARM:
            self._enter(Step.ARMING if self._joins else Step.TAKE_OFF, t)
            self._give(Act.STREAM if self._joins else Act.TAKE_OFF, seen, t)
        elif act is Act.STREAM:
            self._streams = True
            if self._joins:
                self._enter(Step.FLIGHT, t)
                self._answer(granted=True, reason="flying the present setpoints")
        elif act is Act.GLIDE:
            self._enter(Step.GLIDE, t, reason)
        elif act is Act.START:
            self._enter(Step.FLIGHT, t, reason)
            self._answer(granted=True, reason=reason or "the plan has started")
        elif act is Act.BRAKE:
            self._enter(Step.HOLD, t)
        elif act is Act.STOP_STREAM:
            self._give(Act.LAND, seen, t)
        elif act is Act.CUT:
            self._answer(granted=True, reason="motors stopped; restart the vehicles")

    def _fail(self, act: Act, seen: Observation, reason: str, t: float) -> None:
        self._said.append(f"{act.value} failed: {reason}")
        if act in {Act.WAIT, Act.ARM}:
            self.refusal = reason
            self._enter(Step.DISARMING, t)
            self._answer(granted=False, reason=reason)
            self._give(Act.DISARM, seen, t)
        elif act in {Act.TAKE_OFF, Act.STREAM}:  # vehicles may be in the air, whatever the answer was
            self._answer(granted=False, reason=f"{reason}; landing")
            self._land(seen, t, reason)
        elif act is Act.GLIDE and self._lands_after_glide:
            overlap = apart_refusal(seen.names, seen.pos, self._params.apart)
            if overlap:
                self._answer(
                    granted=False, reason=f"{overlap}, and {reason}; land once more to land all the same"
                )
            else:
                self._land(seen, t, f"where they are: {reason}")
        elif act in {Act.STOP_STREAM, Act.LAND}:
            self._streams = self._streamed
            self._enter(Step.HOLD if self._streams else Step.HOVER, t, reason)
            self._answer(granted=False, reason=f"{reason}; call land again, or emergency")
        else:
            self._answer(granted=False, reason=reason)

    def _climb(self, seen: Observation, t: float) -> None:
        height = self._params.ground + self._params.take_off_height
        off = at_height(seen, height, self._params, self._landing)
        if self._rest.lasts(not off, t):
            self._enter(Step.HOVER, t)
            self._answer(granted=True, reason=f"hovering: {places(seen)}")
        elif self._late(self._params.take_off_s, t):
            self._answer(granted=False, reason=f"take-off failed: {off}; landing")
            self._land(seen, t, off)

    def _glide(self, seen: Observation, t: float) -> None:
        if not self._streams:
            refusal = setpoint_refusal(seen, self._params.reached, self._landing)
            if not refusal:
                self._joins = False
                self._give(Act.STREAM, seen, t)
            elif t - self._since > HAND_OVER_S:
                self._enter(Step.HOVER, t, refusal)
                self._answer(granted=False, reason=refusal)
            return
        first = seen.first_points()
        near = bool((_norm(seen.wanted - first) < 0.1 * self._params.reached).all())
        arrived = near and self._wanted_rests(seen)
        off = at_points(seen, first, self._params, self._landing)
        if self._rest.lasts(arrived and not off, t):
            self._arrive(seen, t)
        elif not arrived:
            self._since = t
        elif self._late(0.0, t):
            self._answer(granted=False, reason=f"glide failed: {off}; holding")
            self._enter(Step.HOLD, t, off)

    def _arrive(self, seen: Observation, t: float) -> None:
        if self._lands_after_glide:
            self._land(seen, t)
        else:
            self._give(Act.START, seen, t)

    def _fly(self, seen: Observation, t: float) -> None:
        over = seen.plan is not None and t - self._since > seen.plan.duration
        if over and self._wanted_rests(seen):
            self._enter(Step.HOLD, t, "the plan is over")

    def _hold(self, seen: Observation, t: float) -> None:
        if not self._wanted_rests(seen):
            return
        if self._pending is Call.HOLD:
            self._answer(granted=True, reason=f"holding: {places(seen)}")
        elif self._pending is Call.LAND and self._lands_after_glide:
            self._give(Act.GLIDE, seen, t)

    def _stay(self, seen: Observation, t: float) -> None:
        """Wait for a call."""

    def _descend(self, seen: Observation, t: float) -> None:
        off = at_height(seen, self._params.ground, self._params, self._landing, self._params.near_ground)
        if self._rest.lasts(not off, t):
            self._enter(Step.DISARMING, t)
            self._give(Act.DISARM, seen, t)
        elif self._pending is Call.LAND and self._late(self._order(Act.LAND, seen).duration, t):
            self._answer(granted=False, reason=f"not on the ground: {off}; call land again, or emergency")

    def _on_the_ground(self, seen: Observation, outcome: Reply, t: float) -> None:
        how = "disarmed" if outcome.granted else f"not disarmed: {outcome.reason}"
        self._answer(granted=True, reason=f"on the ground: {places(seen)}; {how}")
        self._enter(Step.CONNECTED, t, how)
        self._looked = -np.inf

    def _stopped(self, seen: Observation, t: float) -> None:
        well = all(one.connected and one.locked is False for one in seen.vehicles)
        if well and t - self._since > self._params.patience_s:
            self._enter(Step.CONNECTED, t, "vehicles were restarted")

    def _look(self, seen: Observation, t: float) -> None:
        if self.step not in ON_GROUND or t - self._looked < LOOK_S:
            return
        self._looked = t
        self.refusal = take_off_refusal(seen, self._params, self._landing)
        before, self.unchecked = self.unchecked, unchecked(seen)
        offline = connection_refusal(seen)
        step = Step.OFFLINE if offline else Step.CONNECTED if self.refusal else Step.CHECKED
        if step is not self.step or (step is Step.CHECKED and self.unchecked != before):
            self._enter(step, t, self.refusal or self.unchecked)

    def _guard(self, seen: Observation, t: float) -> None:
        """Land where setpoints jump or stay away; see where vehicles land by themselves."""
        if not self._streams:
            return
        silent = f"no setpoint for {seen.wanted_age:.2f} s" if seen.wanted_age > self._params.lost_s else ""
        fault = self._fault or silent
        self._fault = ""
        if not any(one.flies for one in seen.vehicles):
            self._streams, self._waiting = False, None
            self._answer(granted=False, reason="no vehicle is flown any more: they land by themselves")
            self._enter(Step.LANDING, t, "by themselves")
        elif fault:
            self._answer(granted=False, reason=f"{fault}: landing")
            self._land(seen, t, fault)

    def _wanted_rests(self, seen: Observation) -> bool:
        """Return whether setpoints move a hundred times slower than a vehicle that rests."""
        return bool((_norm(seen.wanted_vel) < 0.01 * self._params.still_speed).all())

    def _late(self, duration: float, t: float) -> bool:
        return t - self._since > duration + self._params.patience_s

    def _enter(self, step: Step, t: float, why: str = "") -> None:
        self.step, self._since = step, t
        self._rest.reset()
        self._said.append(f"step {step.value}{': ' if why else ''}{why}")

    def _answer(self, *, granted: bool, reason: str) -> None:
        if self._pending is not None:
            self._said.append(f"{self._pending.value}: {reason}")
            self._replies.append((self._pending, Reply(granted=granted, reason=reason)))
        self._pending = None


def _norm(rows: Array) -> Array:
    return np.asarray(np.sqrt((rows * rows).sum(axis=-1)))
