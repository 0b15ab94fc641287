"""Flight procedure: the state machine from ground to ground of `radio` and of the bridge to Crazyswarm2.

    offline -> connected -> checked -- take_off --> arming -> take-off -> hover
        ^                                         hover, hold -- fly --> glide -> flight -> hold
        +-- disarming <- landing <-- land -- take-off, hover, glide, flight, hold

| step | action | ends when |
|---|---|---|
| arming | vehicles arm | all are armed |
| take-off | onboard climb to take_off_height | all are there and at rest |
| glide | streamed setpoints on a certified plan to the plan's first points | all are there |
| flight | the plan's clock runs | the plan ends, or `hold` brakes along it: hold |
| landing | stream stopped, then onboard landing | all are at rest on the ground, by motion capture |
| disarming | vehicles disarm | all are disarmed, or their build arms itself |
| stopped | after `emergency` | all vehicles were restarted |

Nothing moves without a call. A refused call changes nothing. A granted call is answered when it is done, has
failed, or was superseded: `land` supersedes all but itself, `hold` supersedes `fly`, `emergency` all.
`start` skips take-off and glide, for vehicles already at their setpoints. In flight, a jump or a gap of the
setpoints lands all vehicles. From a hold, `land` first glides back to the plan's first points, where the next
flight can begin (land_home); so it does from any step if vehicles overlap horizontally. A second `land` lands
them where they are.
"""

from q2q_control.flight_procedure.checks.arrival import at_height, at_points, heights_text, setpoints_rest
from q2q_control.flight_procedure.checks.ground_check import GroundCheck
from q2q_control.flight_procedure.checks.refusals import apart_refusal, setpoint_refusal, unchecked
from q2q_control.flight_procedure.observation import Observation
from q2q_control.flight_procedure.procedure_params import FlightProcedureParams, LandingParams
from q2q_control.flight_procedure.procedure_state import ProcedureState
from q2q_control.flight_procedure.setpoint_stream import SetpointStream
from q2q_control.flight_procedure.steps import ON_GROUND, Act, Call, Order, Step
from q2q_control.flight_procedure.transitions import ACTS_OF, check_refusal, order_of, step_refusal
from q2q_model.node.reply import Reply
from q2q_model.signals.values import Array

HAND_OVER_S = 1.0
"""Longest time from the start of a glide until its setpoints are at the vehicles [s]."""


class FlightProcedure:
    """Step of a flight, and the pending call."""

    def __init__(self, params: FlightProcedureParams, landing: LandingParams) -> None:
        self._params, self._landing = params, landing
        self.state = ProcedureState(params.settle_s, params.patience_s)
        self._stream = SetpointStream(params.jump, params.lost_s)
        self.ground = GroundCheck(params, landing)
        self._lands_after_glide = False
        self._joins = False

    @property
    def step(self) -> Step:
        """Return the step of the flight."""
        return self.state.step

    def call(self, call: Call, observation: Observation, t: float) -> Reply | None:
        """Make a call at time t [s]; return its reply, or None if that comes later (`state`)."""
        refusal = self._refusal(call, observation)
        if self._params.dry_run:
            acts = ", then ".join(str(self._order(act, observation)) for act in ACTS_OF[call])
            checks = refusal or unchecked(observation) or "all checks pass"
            text = f"dry run, nothing is sent; {checks}; {call.value} means: {acts}"
            self.state.log.append(text)
            return Reply(granted=not refusal, reason=text)
        if refusal:
            self.state.log.append(f"{call.value} refused: {refusal}")
            return Reply(granted=False, reason=refusal)
        self.state.answer(granted=False, reason=f"{call.value} took over")
        self.state.pending = call
        self._begin(call, observation, t)
        return None

    def update(self, observation: Observation, outcome: Reply | None, t: float) -> None:
        """Update at time t [s]; `outcome` is that of the last order, None while it is unknown."""
        self._guard(observation, t)
        if self.state.waiting is not None:
            self._conclude(self.state.waiting, observation, outcome, t)
            return
        follow = {
            Step.TAKE_OFF: self._climb,
            Step.GLIDE: self._glide,
            Step.FLIGHT: self._fly,
            Step.HOLD: self._hold,
            Step.LANDING: self._descend,
            Step.STOPPED: self._stopped,
        }
        follow.get(self.step, self._check_ground)(observation, t)

    def accepts(self, setpoint_pos: Array) -> bool:
        """Return whether to fly setpoints at these positions (n, 3) [m]; NaN is a vehicle without one."""
        return self._stream.accepts(setpoint_pos)

    def _refusal(self, call: Call, observation: Observation) -> str:
        """Return why a call is refused; empty if it is granted."""
        refusal = step_refusal(call, self.step)
        if refusal:
            return refusal
        if self.state.pending is call and call is not Call.EMERGENCY and not self._lands_after_glide:
            return f"{call.value} is under way"
        return check_refusal(call, observation, self._params, self._landing)

    def _begin(self, call: Call, observation: Observation, t: float) -> None:
        again, self._lands_after_glide = self._lands_after_glide, False
        if call is Call.EMERGENCY:
            self._stream.on = False
            self.state.enter(Step.STOPPED, t)
            self._give(Act.CUT, observation, t)
        elif call in {Call.TAKE_OFF, Call.START}:
            self._joins = call is Call.START
            self.state.enter(Step.ARMING, t, unchecked(observation) or "all checks passed")
            self._give(Act.ARM if self._joins else Act.WAIT, observation, t)
        elif call is Call.FLY:
            self._give(Act.GLIDE, observation, t)
        elif call is Call.HOLD:
            self._give(Act.BRAKE, observation, t)
        else:
            self._begin_landing(observation, t, again=again)

    def _begin_landing(self, observation: Observation, t: float, *, again: bool) -> None:
        """Land; from a hold, or if vehicles overlap, after a glide, unless called `again`."""
        if self.step is Step.ARMING:
            self.state.enter(Step.DISARMING, t)
            self._give(Act.DISARM, observation, t)
            return
        overlap = apart_refusal(observation.names, observation.pos, self._params.apart)
        home = overlap or (self._params.land_home and self.step is Step.HOLD)
        flown = observation.plan is not None and self.step in {Step.GLIDE, Step.FLIGHT, Step.HOLD}
        if home and flown and not again:
            self.state.log.append(f"{overlap or 'land'}: first a glide to the plan's first points")
            self._lands_after_glide = True
            self._give(Act.GLIDE if self.step is Step.HOLD else Act.BRAKE, observation, t)
            return
        self._land(observation, t)

    def _land(self, observation: Observation, t: float, why: str = "") -> None:
        self._stream.stop()
        self.state.enter(Step.LANDING, t, why)
        self._give(Act.STOP_STREAM, observation, t)

    def _give(self, act: Act, observation: Observation, t: float) -> None:
        self.state.give(self._order(act, observation), t)

    def _order(self, act: Act, observation: Observation) -> Order:
        return order_of(act, observation, self._params, self._landing)

    def _conclude(self, order: Order, observation: Observation, outcome: Reply | None, t: float) -> None:
        """Handle the outcome of an order; one that is late is a failure."""
        outcome = outcome or self.state.overdue(order, t)
        if outcome is None:
            return
        self.state.waiting = None
        if order.act is Act.DISARM:
            self._on_the_ground(observation, outcome, t)
        elif outcome.granted:
            self._succeed(order.act, observation, outcome.reason, t)
        else:
            self._fail(order.act, observation, outcome.reason, t)

    def _succeed(self, act: Act, observation: Observation, reason: str, t: float) -> None:
        if act is Act.WAIT:
            self._give(Act.ARM, observation, t)
        elif act is Act.ARM:
            self.state.enter(Step.ARMING if self._joins else Step.TAKE_OFF, t)
            self._give(Act.STREAM if self._joins else Act.TAKE_OFF, observation, t)
        elif act is Act.STREAM:
            self._stream.start()
            if self._joins:
                self.state.enter(Step.FLIGHT, t)
                self.state.answer(granted=True, reason="flying the present setpoints")
        elif act is Act.GLIDE:
            self.state.enter(Step.GLIDE, t, reason)
        elif act is Act.START:
            self.state.enter(Step.FLIGHT, t, reason)
            self.state.answer(granted=True, reason=reason or "the plan has started")
        elif act is Act.BRAKE:
            self.state.enter(Step.HOLD, t)
        elif act is Act.STOP_STREAM:
            self._give(Act.LAND, observation, t)
        elif act is Act.CUT:
            self.state.answer(granted=True, reason="motors stopped; restart the vehicles")

    def _fail(self, act: Act, observation: Observation, reason: str, t: float) -> None:
        self.state.log.append(f"{act.value} failed: {reason}")
        if act in {Act.WAIT, Act.ARM}:
            self.ground.refusal = reason
            self.state.enter(Step.DISARMING, t)
            self.state.answer(granted=False, reason=reason)
            self._give(Act.DISARM, observation, t)
        elif act in {Act.TAKE_OFF, Act.STREAM}:  # vehicles may be in the air despite the failure
            self.state.answer(granted=False, reason=f"{reason}; landing")
            self._land(observation, t, reason)
        elif act is Act.GLIDE and self._lands_after_glide:
            overlap = apart_refusal(observation.names, observation.pos, self._params.apart)
            if overlap:
                self.state.answer(
                    granted=False, reason=f"{overlap}, and {reason}; land once more to land all the same"
                )
            else:
                self._land(observation, t, f"where they are: {reason}")
        elif act in {Act.STOP_STREAM, Act.LAND}:
            self._stream.on = self._stream.before
            self.state.enter(Step.HOLD if self._stream.on else Step.HOVER, t, reason)
            self.state.answer(granted=False, reason=f"{reason}; call land again, or emergency")
        else:
            self.state.answer(granted=False, reason=reason)

    def _climb(self, observation: Observation, t: float) -> None:
        height = self._params.ground + self._params.take_off_height
        off = at_height(observation, height, self._params, self._landing)
        if self.state.settled.update(not off, t):
            self.state.enter(Step.HOVER, t)
            self.state.answer(granted=True, reason=f"hovering: {heights_text(observation)}")
        elif self.state.late(self._params.take_off_s, t):
            self.state.answer(granted=False, reason=f"take-off failed: {off}; landing")
            self._land(observation, t, off)

    def _glide(self, observation: Observation, t: float) -> None:
        if not self._stream.on:
            refusal = setpoint_refusal(observation, self._params.reached, self._landing)
            if not refusal:
                self._joins = False
                self._give(Act.STREAM, observation, t)
            elif t - self.state.since > HAND_OVER_S:
                self.state.enter(Step.HOVER, t, refusal)
                self.state.answer(granted=False, reason=refusal)
            return
        first = observation.first_points()
        arrived = setpoints_rest(observation, self._params, first)
        off = at_points(observation, first, self._params, self._landing)
        if self.state.settled.update(arrived and not off, t):
            self._arrive(observation, t)
        elif not setpoints_rest(observation, self._params):
            self.state.moving(t)
        elif self.state.late(0.0, t):
            why = off or "the setpoints rest elsewhere than at the first points"
            then = "call land again to land where they are" if self._lands_after_glide else "holding"
            self.state.answer(granted=False, reason=f"glide failed: {why}; {then}")
            self.state.enter(Step.HOLD, t, why)

    def _arrive(self, observation: Observation, t: float) -> None:
        if self._lands_after_glide:
            self._land(observation, t)
        else:
            self._give(Act.START, observation, t)

    def _fly(self, observation: Observation, t: float) -> None:
        over = observation.plan is not None and t - self.state.since > observation.plan.duration
        if over and setpoints_rest(observation, self._params):
            self.state.enter(Step.HOLD, t, "the plan is over")

    def _hold(self, observation: Observation, t: float) -> None:
        if not setpoints_rest(observation, self._params):
            if self.state.late(0.0, t):
                self.state.answer(granted=False, reason="the setpoints do not come to rest; call land again")
            return
        if self.state.pending is Call.HOLD:
            self.state.answer(granted=True, reason=f"holding: {heights_text(observation)}")
        elif self.state.pending is Call.LAND and self._lands_after_glide:
            self._give(Act.GLIDE, observation, t)

    def _descend(self, observation: Observation, t: float) -> None:
        off = at_height(
            observation, self._params.ground, self._params, self._landing, self._params.near_ground
        )
        if self.state.settled.update(not off, t):
            self.state.enter(Step.DISARMING, t)
            self._give(Act.DISARM, observation, t)
        elif (
            off
            and self.state.pending is Call.LAND
            and self.state.late(self._order(Act.LAND, observation).duration, t)
        ):
            self.state.answer(
                granted=False, reason=f"not on the ground: {off}; call land again, or emergency"
            )

    def _on_the_ground(self, observation: Observation, outcome: Reply, t: float) -> None:
        how = "disarmed" if outcome.granted else f"not disarmed: {outcome.reason}"
        self.state.answer(granted=True, reason=f"on the ground: {heights_text(observation)}; {how}")
        self.state.enter(Step.CONNECTED, t, how)
        self.ground.reset()

    def _stopped(self, observation: Observation, t: float) -> None:
        well = all(one.connected and one.locked is False for one in observation.vehicles)
        if well and t - self.state.since > self._params.patience_s:
            self.state.enter(Step.CONNECTED, t, "vehicles were restarted")

    def _check_ground(self, observation: Observation, t: float) -> None:
        step = self.ground.update(self.step, observation, t) if self.step in ON_GROUND else None
        if step is not None:
            self.state.enter(step, t, self.ground.refusal or self.ground.unchecked)

    def _guard(self, observation: Observation, t: float) -> None:
        """Land if setpoints jump or are missing; follow vehicles that land by themselves."""
        if not self._stream.on:
            return
        fault = self._stream.take_fault(observation.setpoint_age)
        if not any(one.flies for one in observation.vehicles):
            self._stream.on, self.state.waiting = False, None
            self.state.answer(granted=False, reason="no vehicle flies setpoints: all land by themselves")
            self.state.enter(Step.LANDING, t, "by themselves")
        elif fault:
            self.state.answer(granted=False, reason=f"{fault}: landing")
            self._land(observation, t, fault)
