"""Services of the flight procedure: `~/start`, `~/take_off`, `~/fly`, `~/hold`, `~/land`, `~/emergency`.

Each answers when the request is done, or with the reason why it is not. `procedure/status` (latched) has the
step, what refuses a take-off, and what cannot be checked; every step is logged in one line.
"""

from collections.abc import Callable
from functools import partial
from time import monotonic

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from q2q_msgs.msg import Plan
from rclpy.node import Node

from q2q_control.flight_procedure.hand_over import STATUS_TOPIC, reporter_name
from q2q_control.flight_procedure.observation import plan_outline
from q2q_control.flight_procedure.procedure_params import FlightProcedureParams, LandingParams
from q2q_control.flight_procedure.state_machine.piloted_flight import (
    OrderExecutor,
    PilotedFlight,
    ProcedureStatus,
)
from q2q_control.flight_procedure.steps import Act, Call, Step
from q2q_control.ros.trajectory_client import TrajectoryClient
from q2q_model.node.reply import Reply
from q2q_model.ros.node.late_reply import LateReplyService
from q2q_model.ros.node.steady_timer import steady_timer
from q2q_model.ros.topics.plan_message import decode_trajectories
from q2q_model.ros.topics.qos import LATCHED
from q2q_model.signals.topic_names import NEXT_PLAN
from q2q_model.signals.values import Names, SwarmCommand, SwarmSetpoint, SwarmState

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
        self._node = node
        self._flight = PilotedFlight(names, executor, TrajectoryClient(node), params)
        self._status = node.create_publisher(DiagnosticStatus, STATUS_TOPIC, LATCHED)
        self._services: dict[Call | Act, list[LateReplyService]] = {
            call: [LateReplyService(node, f"~/{call.value}", partial(self._call, call))] for call in Call
        }
        node.create_subscription(Plan, NEXT_PLAN, self._take_plan, LATCHED)
        steady_timer(node, PERIOD_S, self._update)

    def refuse_flights(self, refusal: Callable[[], str]) -> None:
        """Refuse the calls that begin a flight while `refusal` returns a reason."""
        self._flight.refusal = refusal

    def store_state(self, state: SwarmState) -> None:
        """Store a state."""
        self._flight.store_state(state, monotonic())

    def store_command(self, command: SwarmCommand) -> None:
        """Store a controller's command."""
        self._flight.store_command(command)

    def store_setpoint(self, setpoint: SwarmSetpoint) -> None:
        """Store a setpoint."""
        self._flight.store_setpoint(setpoint, monotonic())

    @property
    def streams(self) -> bool:
        """Return whether ticks are flown now."""
        return self._flight.streams

    def offer(self, name: str, act: Act) -> None:
        """Offer one act of the executor as a service, while vehicles stand on the ground."""
        service = LateReplyService(
            self._node, f"~/{name}", lambda: self._flight.begin_single(act, name, monotonic())
        )
        self._services[act] = [service]

    def offer_also(self, name: str, call: Call) -> None:
        """Offer a call by another name, too."""
        service = LateReplyService(self._node, f"~/{name}", partial(self._call, call))
        self._services[call].append(service)

    def emergency(self) -> None:
        """Stop all motors and lock them."""
        self._call(Call.EMERGENCY)

    def land_here(self) -> float:
        """Land without a transit; return how long to wait for that [s], 0 if vehicles stand on the ground."""
        seconds = self._flight.land_here(monotonic())
        self._pass_on()
        return seconds

    @property
    def comes_down(self) -> bool:
        """Return whether a landing is under way."""
        return self._flight.comes_down

    def _call(self, call: Call) -> Reply | None:
        reply = self._flight.call(call, monotonic())
        self._pass_on()
        return reply

    def _update(self) -> None:
        self._flight.update(monotonic())
        self._pass_on()

    def _take_plan(self, message: Plan) -> None:
        try:
            self._flight.store_plan(plan_outline(tuple(message.names), decode_trajectories(message)))
        except ValueError as refusal:
            self._node.get_logger().error(f"next_plan refused, the last one is kept: {refusal}")

    def _pass_on(self) -> None:
        for line in self._flight.log_lines():
            self._node.get_logger().info(line)
        for request, reply in self._flight.replies():
            for service in self._services[request]:
                service.answer(reply)
        status = self._flight.new_status()
        if status is not None:
            self._status.publish(_status_message(self._node.get_fully_qualified_name(), status))


def _status_message(node: str, status: ProcedureStatus) -> DiagnosticStatus:
    return DiagnosticStatus(
        level=DiagnosticStatus.ERROR if status.step is Step.STOPPED else DiagnosticStatus.OK,
        name=reporter_name(node),
        message=status.step.value,
        hardware_id="q2q",
        values=[
            KeyValue(key="take_off_refusal", value=status.refusal),
            KeyValue(key="unchecked", value=status.unchecked),
        ],
    )
