"""Flight procedure: the state machine from ground to ground of `radio` and of the bridge to Crazyswarm2.

    offline -> connected -> checked -- take_off --> arming -> take-off -> hover
        ^                                         hover, hold -- fly --> transit -> flight -> hold
        +-- disarming <- landing <-- land -- take-off, hover, transit, flight, hold

| step | action | ends when |
|---|---|---|
| arming | vehicles arm | all are armed |
| take-off | onboard climb to take_off_height | all are there and at rest |
| transit | streamed setpoints on a certified plan to the plan's first points | all are there |
| flight | the plan's clock runs | the plan ends, or `hold` brakes along it: hold |
| landing | stream stopped, then onboard landing | its duration is over, all measured at rest on the ground |
| disarming | vehicles disarm | all are disarmed, or their build arms itself |
| stopped | after `emergency` | all vehicles were locked or offline, then restarted |

Nothing moves without a call. A refused call changes nothing. A granted call is answered when it is done, has
failed, or was superseded: `land` supersedes all but itself, `hold` supersedes `fly`, `emergency` all. An
`emergency` that is called again is sent again, and one outcome answers both calls. In a dry run no call but
`emergency` is executed.
`start` skips take-off and transit, for vehicles already at their setpoints. In flight, all vehicles land when
setpoints jump or stay away, or with Crazyswarm2 when nothing is sent to a vehicle. From a hold, `land` first
transits back to the plan's first points, where the next flight can begin (land_home); so it does from any
step if vehicles overlap horizontally. A second `land` lands them where they are; one outcome answers both.
"""

from q2q_control.flight_procedure.checks.flight_checks import unchecked
from q2q_control.flight_procedure.observation import Observation
from q2q_control.flight_procedure.procedure_params import FlightProcedureParams, LandingParams
from q2q_control.flight_procedure.state_machine.active_flight import ActiveFlight
from q2q_control.flight_procedure.state_machine.order_outcomes import conclude
from q2q_control.flight_procedure.state_machine.procedure_state import ProcedureState
from q2q_control.flight_procedure.state_machine.step_ends import end_step
from q2q_control.flight_procedure.state_machine.transitions import ACTS_OF, check_refusal, step_refusal
from q2q_control.flight_procedure.steps import FLYING, Act, Call, Step
from q2q_model.counted import listed
from q2q_model.node.reply import Reply
from q2q_model.signals.values import Array


class FlightProcedure:
    """Step of a flight, and the pending call."""

    def __init__(self, params: FlightProcedureParams, landing: LandingParams) -> None:
        self._flight = ActiveFlight(params, landing)
        self.ground = self._flight.ground

    @property
    def state(self) -> ProcedureState:
        """Return the step, the pending call, and what is to be sent."""
        return self._flight.state

    @property
    def step(self) -> Step:
        """Return the step of the flight."""
        return self.state.step

    def call(self, call: Call, observation: Observation, t: float) -> Reply | None:
        """Make a call at time t [s]; return its reply, or None if that comes later (`state`)."""
        refusal = self._refusal(call, observation)
        if self._flight.params.dry_run and call is not Call.EMERGENCY:
            acts = ", then ".join(str(self._flight.order(act, observation)) for act in ACTS_OF[call])
            checks = refusal or unchecked(observation) or "all checks pass"
            text = f"dry run, not executed; {checks}; {call.value} means: {acts}"
            self.state.log.append(text)
            return Reply(granted=not refusal, reason=text)
        if refusal:
            self.state.log.append(f"{call.value} refused: {refusal}")
            return Reply(granted=False, reason=refusal)
        if self.state.pending is not call:  # called again: one outcome answers both
            self.state.answer(granted=False, reason=f"{call.value} took over")
        self.state.pending = call
        self._begin(call, observation, t)
        return None

    def update(self, observation: Observation, outcome: Reply | None, t: float) -> None:
        """Update at time t [s]; `outcome` is that of the last order, None while it is unknown."""
        self._check_stream(observation, t)
        if self.state.waiting is not None:
            conclude(self._flight, self.state.waiting, observation, outcome, t)
        else:
            end_step(self._flight, observation, t)

    def land_here(self, observation: Observation, t: float) -> float:
        """Land without a call and without a transit, as the node ends at time t [s].

        Returns:
            how long to wait until all are down at the latest [s].
        """
        seconds = self._flight.order(Act.LAND, observation).duration + self._flight.params.step_timeout_s
        if self.step in FLYING | {Step.ARMING}:
            self.state.answer(granted=False, reason="the node is shutting down: landing")
            self._flight.lands_after_transit = False
            self._begin_landing(observation, t, again=True)
        return seconds

    def take_setpoint(self, setpoint_pos: Array) -> None:
        """Take the setpoints' positions (n, 3) [m]; NaN is a vehicle without one."""
        self._flight.stream.take(setpoint_pos)

    @property
    def streams(self) -> bool:
        """Return whether ticks are flown now: setpoints are streamed and have not jumped."""
        return self._flight.stream.flies

    def _refusal(self, call: Call, observation: Observation) -> str:
        """Return why a call is refused; empty if it is granted."""
        refusal = step_refusal(call, self.step)
        if refusal:
            return refusal
        if self.state.pending is call and call is not Call.EMERGENCY and not self._flight.lands_after_transit:
            return f"{call.value} is in progress"
        return check_refusal(call, observation, self._flight.params, self._flight.landing)

    def _begin(self, call: Call, observation: Observation, t: float) -> None:
        flight = self._flight
        again, flight.lands_after_transit = flight.lands_after_transit, False
        if call is Call.EMERGENCY:
            flight.stream.on = False
            flight.down.clear()
            self.state.enter(Step.STOPPED, t)
            flight.give(Act.EMERGENCY, observation, t)
        elif call in {Call.TAKE_OFF, Call.START}:
            flight.joins = call is Call.START
            self.state.enter(Step.ARMING, t, unchecked(observation) or "all checks passed")
            flight.give(Act.ARM if flight.joins else Act.WAIT, observation, t)
        elif call is Call.FLY:
            flight.give(Act.TRANSIT, observation, t)
        elif call is Call.HOLD:
            flight.give(Act.BRAKE, observation, t)
        else:
            self._begin_landing(observation, t, again=again)

    def _begin_landing(self, observation: Observation, t: float, *, again: bool) -> None:
        """Land; from a hold, or if vehicles overlap, after a transit, unless called `again`."""
        flight, waiting = self._flight, self.state.waiting
        streams = waiting is not None and waiting.act is Act.STREAM  # after `start`: vehicles may fly
        if self.step is Step.ARMING and not streams:
            self.state.enter(Step.DISARMING, t)
            flight.give(Act.DISARM, observation, t)
            return
        overlap = flight.overlap(observation)
        home = overlap or (flight.params.land_home and self.step is Step.HOLD)
        flown = observation.plan is not None and self.step in {Step.TRANSIT, Step.FLIGHT, Step.HOLD}
        if home and flown and not again:
            self.state.log.append(f"{overlap or 'land'}: first a transit to the plan's first points")
            flight.lands_after_transit = True
            flight.give(Act.TRANSIT if self.step is Step.HOLD else Act.BRAKE, observation, t)
            return
        flight.land(observation, t)

    def _check_stream(self, observation: Observation, t: float) -> None:
        """Land if setpoints jump, are missing or are not sent; follow vehicles that land by themselves."""
        stream = self._flight.stream
        if not stream.on:
            return
        unsent = {f"nothing sent to {one.name}": one.silent_s for one in observation.vehicles}
        fault = stream.take_fault({"no setpoint": observation.setpoint_age} | unsent, t)
        if not any(one.flies for one in observation.vehicles):
            stream.on, self.state.waiting = False, None
            self._leave_alone(observation, t)
        elif fault:
            self.state.answer(granted=False, reason=f"{fault}: landing")
            self._flight.land(observation, t, fault)

    def _leave_alone(self, observation: Observation, t: float) -> None:
        """Follow vehicles that no longer fly setpoints: their motors were cut, or they land."""
        cut = [one.name for one in observation.vehicles if one.cut]
        why = f"motors of {listed(cut)} stopped" if cut else "by themselves"
        self.state.answer(granted=False, reason=f"no vehicle follows setpoints: landing, {why}")
        self.state.enter(Step.LANDING, t, why)
        lands = len(cut) < len(observation.vehicles)
        self._flight.landing_end = t + self._flight.order(Act.LAND, observation).duration if lands else t
