"""Services of the flight procedure: `~/start`, `~/take_off`, `~/fly`, `~/hold`, `~/land`, `~/emergency`.

Each answers when the request is done, or with the reason why it is not. `~/status` (latched) has the step,
what refuses a take-off, and what cannot be checked; every step is logged in one line. Orders go to an
executor, those of the plan to the node `trajectory`.
"""

from collections.abc import Callable
from functools import partial
from time import monotonic

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from q2q_msgs.msg import Plan
from rclpy.node import Node

from q2q_control.flight_procedure.flight_view import FlightView
from q2q_control.flight_procedure.observation import Observation, outline
from q2q_control.flight_procedure.order_executor import OrderExecutor
from q2q_control.flight_procedure.procedure import FlightProcedure
from q2q_control.flight_procedure.procedure_params import FlightProcedureParams, LandingParams
from q2q_control.flight_procedure.steps import ON_GROUND, Act, Call, Order, Step
from q2q_control.ros.trajectory_client import CALLS, TrajectoryClient
from q2q_model.node.reply import Reply
from q2q_model.ros.node.late_reply import LateReplyService
from q2q_model.ros.node.steady_timer import steady_timer
from q2q_model.ros.topics.plan_message import decode_trajectories
from q2q_model.ros.topics.qos import LATCHED
from q2q_model.signals.values import Names, SwarmSetpoint, SwarmState

PERIOD_S = 0.02
"""Period of the procedure's updates [s]."""


class ProcedureServices:
    """Flight procedure of one node with its services."""

    def __init__(
        self,
        node: Node,
        names: Names,
        executor: OrderExecutor,
        params: tuple[FlightProcedureParams, LandingParams],
    ) -> None:
        """Serve the procedure of some vehicles."""
        self._node, self._executor = node, executor
        self._procedure = FlightProcedure(*params)
        self._view = FlightView(names)
        self._trajectory = TrajectoryClient(node)
        self._status = node.create_publisher(DiagnosticStatus, "~/status", LATCHED)
        self._published: tuple[Step, str, str] | None = None
        self._single: LateReplyService | None = None
        """Service of a single act that is under way."""
        self._services = {
            call: LateReplyService(node, f"~/{call.value}", partial(self._call, call)) for call in Call
        }
        node.create_subscription(Plan, "next_plan", self._take_plan, LATCHED)
        steady_timer(node, PERIOD_S, self.move_on)
        self.guard: Callable[[Call], str] = lambda _: ""
        """Returns why the node itself refuses a call; empty if it does not."""

    def store_state(self, state: SwarmState) -> None:
        """Store a state."""
        self._view.store_state(state, monotonic())

    def accepts(self, setpoint: SwarmSetpoint) -> bool:
        """Store a setpoint; return whether to fly it."""
        return self._procedure.accepts(self._view.store_setpoint(setpoint, monotonic()))

    def offer(self, name: str, act: Act) -> None:
        """Offer one act of the executor as a service, while vehicles stand on the ground."""

        def ask() -> Reply | None:
            step = self._procedure.step
            if step not in ON_GROUND or self._single is not None:
                return Reply(granted=False, reason=f"the step is {step.value}: {name} is for the ground")
            self._single = service
            self._executor.begin(Order(act), monotonic())
            return None

        service = LateReplyService(self._node, f"~/{name}", ask)

    def emergency(self) -> None:
        """Stop all motors and lock them."""
        self._call(Call.EMERGENCY)

    def move_on(self) -> None:
        """Update the procedure and publish its status."""
        now = monotonic()
        outcome = self._executor.outcome(now) or self._trajectory.outcome()
        if self._single is not None and outcome is not None:
            self._single.answer(outcome)
            self._single, outcome = None, None
        self._procedure.update(self._observed(now), outcome, now)
        self._pass_on(now)

    def _call(self, call: Call) -> Reply | None:
        refusal = self.guard(call)
        if refusal:
            return Reply(granted=False, reason=refusal)
        if self._single is not None:
            self._single.answer(Reply(granted=False, reason=f"{call.value} took over"))
            self._single = None
        now = monotonic()
        reply = self._procedure.call(call, self._observed(now), now)
        self._pass_on(now)
        return reply

    def _pass_on(self, now: float) -> None:
        for order in self._procedure.orders():
            if order.act in CALLS:
                self._trajectory.begin(order.act)
            else:
                self._executor.begin(order, now)
        for line in self._procedure.log_lines():
            self._node.get_logger().info(line)
        for call, reply in self._procedure.replies():
            self._services[call].answer(reply)
        self._publish_status()

    def _publish_status(self) -> None:
        now = (self._procedure.step, self._procedure.ground.refusal, self._procedure.ground.unchecked)
        if now == self._published:
            return
        self._published = now
        step, refusal, unchecked = now
        level = DiagnosticStatus.ERROR if step is Step.STOPPED else DiagnosticStatus.OK
        self._status.publish(
            DiagnosticStatus(
                level=level,
                name=f"{self._node.get_fully_qualified_name()}: flight procedure",
                message=step.value,
                hardware_id="q2q",
                values=[
                    KeyValue(key="take_off_refusal", value=refusal),
                    KeyValue(key="unchecked", value=unchecked),
                ],
            )
        )

    def _observed(self, now: float) -> Observation:
        return self._view.observe(self._executor.reports(), now)

    def _take_plan(self, message: Plan) -> None:
        self._view.plan = outline(tuple(message.names), decode_trajectories(message))
