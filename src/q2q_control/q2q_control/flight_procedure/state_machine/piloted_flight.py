"""Flight procedure with the executors of its orders: calls and times in; replies, log lines and status out.

Orders to the plan (PLAN_ACTS) go to the executor of the plan, all others to that of the vehicles. On the
ground, a single act of the vehicles' executor may be requested by itself; a call supersedes it.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from q2q_control.flight_procedure.flight_view import FlightView
from q2q_control.flight_procedure.observation import Observation, PlanOutline, VehicleReport
from q2q_control.flight_procedure.procedure_params import FlightProcedureParams, LandingParams
from q2q_control.flight_procedure.state_machine.procedure import FlightProcedure
from q2q_control.flight_procedure.steps import BEGINS_FLIGHT, ON_GROUND, Act, Call, Order, Step
from q2q_model.node.reply import Reply
from q2q_model.signals.values import Names, SwarmCommand, SwarmSetpoint, SwarmState

PLAN_ACTS = frozenset({Act.WAIT, Act.TRANSIT, Act.START, Act.BRAKE})
"""Acts of the plan's playback."""


class OrderExecutor(Protocol):
    """Executor of orders to vehicles: a radio pilot, or Crazyswarm2's server."""

    def begin(self, order: Order, t: float) -> None:
        """Start executing an order at time t [s]."""

    def outcome(self, t: float) -> Reply | None:
        """Return the outcome of the last order by time t [s], once; None while it is unknown."""

    def reports(self) -> tuple[VehicleReport, ...]:
        """Return the report of every vehicle."""


class PlanExecutor(Protocol):
    """Executor of PLAN_ACTS."""

    def begin(self, act: Act) -> None:
        """Start executing an act."""

    def outcome(self) -> Reply | None:
        """Return the outcome of the last act, once; None while it is unknown."""


@dataclass(frozen=True, slots=True)
class ProcedureStatus:
    """Status of the procedure."""

    step: Step
    refusal: str
    """Why a take-off is refused; empty if it is not."""
    unchecked: str
    """What cannot be checked."""


class PilotedFlight:
    """Flight procedure, its view of the vehicles, and a single act under way."""

    def __init__(
        self,
        names: Names,
        executor: OrderExecutor,
        plan_executor: PlanExecutor,
        params: tuple[FlightProcedureParams, LandingParams],
    ) -> None:
        self._executor, self._plan_executor = executor, plan_executor
        self._procedure = FlightProcedure(*params)
        self._dry_run, self._step_timeout_s = params[0].dry_run, params[0].step_timeout_s
        self._view = FlightView(names)
        self._single: Act | None = None
        self._single_at = -math.inf
        self._replies: list[tuple[Call | Act, Reply]] = []
        self._reported: ProcedureStatus | None = None
        self.refusal: Callable[[], str] = lambda: ""
        """Returns why no flight may begin besides the procedure's own reasons; empty if it may."""

    def store_state(self, state: SwarmState, t: float) -> None:
        """Store a state received at time t [s]."""
        self._view.store_state(state, t)

    def store_command(self, command: SwarmCommand) -> None:
        """Store a controller's command."""
        self._view.store_command(command)

    def store_plan(self, plan: PlanOutline) -> None:
        """Store the plan that is waiting."""
        self._view.plan = plan

    def store_setpoint(self, setpoint: SwarmSetpoint, t: float) -> None:
        """Store a setpoint received at time t [s]."""
        self._procedure.take_setpoint(self._view.store_setpoint(setpoint, t))

    @property
    def streams(self) -> bool:
        """Return whether ticks are flown now."""
        return self._procedure.streams

    def call(self, call: Call, t: float) -> Reply | None:
        """Make a call at time t [s]; return its reply, or None if that comes later (`replies`)."""
        refusal = self.refusal() if call in BEGINS_FLIGHT else ""
        if refusal:
            return Reply(granted=False, reason=refusal)
        reply = self._procedure.call(call, self._observed(t), t)
        if reply is None:
            self._answer_single(Reply(granted=False, reason=f"{call.value} took over"))
        self._execute(t)
        return reply

    def land_here(self, t: float) -> float:
        """Land without a transit at time t [s]; return how long to wait for that [s], 0 on the ground."""
        if self._procedure.step in ON_GROUND | {Step.STOPPED}:
            return 0.0
        seconds = self._procedure.land_here(self._observed(t), t)
        self._execute(t)
        return seconds

    @property
    def comes_down(self) -> bool:
        """Return whether a landing is under way."""
        return self._procedure.step in {Step.LANDING, Step.DISARMING}

    def begin_single(self, act: Act, name: str, t: float) -> Reply | None:
        """Start a single act, `name` in messages; return why it is refused, or None if it has started."""
        refusal = self._single_refusal(name)
        if refusal:
            return Reply(granted=False, reason=refusal)
        if self._dry_run:
            return Reply(granted=False, reason=f"dry run, not executed; {name} means: {act.value}")
        self._single, self._single_at = act, t
        self._executor.begin(Order(act), t)
        return None

    def update(self, t: float) -> None:
        """Update the procedure at time t [s]."""
        order = self._procedure.state.waiting
        planned = order is not None and order.act in PLAN_ACTS
        outcome = self._plan_executor.outcome() if planned else self._executor.outcome(t)
        if self._single is not None:
            self._conclude_single(outcome, t)
            outcome = None
        self._procedure.update(self._observed(t), outcome, t)
        self._execute(t)

    def replies(self) -> list[tuple[Call | Act, Reply]]:
        """Return and clear the replies to pending calls and single acts."""
        replies, self._replies = [*self._replies, *self._procedure.state.take_replies()], []
        return replies

    def log_lines(self) -> list[str]:
        """Return and clear the log lines."""
        return self._procedure.state.take_log()

    def new_status(self) -> ProcedureStatus | None:
        """Return the status if it has changed since the last call."""
        ground = self._procedure.ground
        status = ProcedureStatus(self._procedure.step, ground.refusal, ground.unchecked)
        if status == self._reported:
            return None
        self._reported = status
        return status

    def _single_refusal(self, name: str) -> str:
        """Return why a single act is refused; empty if it is not."""
        step = self._procedure.step
        if step not in ON_GROUND:
            return f"the step is {step.value}: {name} is allowed on the ground only"
        return "" if self._single is None else f"{self._single.value} is in progress"

    def _conclude_single(self, outcome: Reply | None, t: float) -> None:
        """Answer the single act with its outcome; one that is late is a failure."""
        if outcome is None and t - self._single_at > self._step_timeout_s:
            outcome = Reply(granted=False, reason=f"no answer in {self._step_timeout_s:g} s")
        if outcome is not None:
            self._answer_single(outcome)

    def _answer_single(self, reply: Reply) -> None:
        """Answer a single act, if one is under way."""
        act, self._single = self._single, None
        if act is not None:
            self._replies.append((act, reply))

    def _execute(self, t: float) -> None:
        for order in self._procedure.state.take_orders():
            if order.act in PLAN_ACTS:
                self._plan_executor.begin(order.act)
            else:
                self._executor.begin(order, t)

    def _observed(self, t: float) -> Observation:
        return self._view.observe(self._executor.reports(), t)
