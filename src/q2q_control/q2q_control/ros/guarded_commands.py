"""Guard of a controller node: an emergency service, the hand-over in flight and, live, a deadline on inputs.

Live, a timer checks every TICK_S for a missing tick. DDS events (deadline, liveliness) would report 7 ms
earlier, but to take one can block a process for ever in the rmw_fastrtps of Jazzy (ros2/rmw_fastrtps#890).
When the flight procedure of `radio` or `crazyswarm` begins to fly its commands, the controller is reset.
"""

from time import monotonic

from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.node import Node
from std_srvs.srv import Empty

from q2q_control.controller import Controller
from q2q_control.failsafe.fallback_params import FallbackParams
from q2q_control.failsafe.guard import Guard, on_time
from q2q_control.failsafe.input_deadline import InputDeadline
from q2q_control.failsafe.phase_changes import EMERGENCY_CUT, PhaseChanges, cut_reason
from q2q_control.failsafe.stamp_delay import StampDelayMonitor
from q2q_control.flight_procedure.hand_over import (
    RECORDED_STATUS_TOPICS,
    STATUS_TOPIC,
    HandOvers,
    reporter_name,
)
from q2q_control.inputs.far_setpoints import FarSetpointMonitor
from q2q_model.ros.node.publisher_conflicts import publishers_of
from q2q_model.ros.node.steady_timer import steady_timer
from q2q_model.ros.node.tick_wiring import TickWiring
from q2q_model.ros.topics.qos import LATCHED
from q2q_model.signals.layout import Signal
from q2q_model.signals.stamps import TICK_S, stamp_from_time
from q2q_model.signals.values import (
    SATURATED,
    CommandStatus,
    Interference,
    Names,
    SwarmCommand,
    SwarmSetpoint,
    SwarmState,
)

EMERGENCY = "all/emergency"
"""Name of the emergency service, as in Crazyswarm2."""


class GuardedCommands:
    """Guard of a controller node, with the newest state and, live, the deadline on inputs."""

    def __init__(
        self, controller: Controller, params: FallbackParams, hover_thrust: float, *, live: bool
    ) -> None:
        self._stamp_delay = StampDelayMonitor()
        self._guard = Guard(controller, params, hover_thrust, self._lateness if live else on_time)
        self._deadline = InputDeadline(self._guard, params) if live else None
        self._state: SwarmState | None = None
        self._flown: tuple[SwarmState, SwarmSetpoint, Names] | None = None  # the last tick and its vehicles
        self._far = FarSetpointMonitor()
        self._changes = PhaseChanges()
        self._hand_overs = HandOvers()

    def update(
        self, state: SwarmState, setpoint: SwarmSetpoint, interference: Interference | None = None
    ) -> SwarmCommand:
        """Return the command of the tick."""
        command = self._guard.update(state, setpoint, interference)
        self._flown = state, setpoint, command.names
        if self._deadline is not None:
            self._deadline.answered(setpoint, monotonic())
        return command

    def wire(self, node: Node, wiring: TickWiring[SwarmCommand]) -> None:
        """Offer the emergency service, await hand-overs, count fallbacks and, live, check the deadline."""
        self._node, self._wiring = node, wiring
        node.create_service(Empty, EMERGENCY, self._on_emergency)
        wiring.after_publish(self._count)
        wiring.check_each_second(self._look_for_far_setpoints)
        for topic in (STATUS_TOPIC, *RECORDED_STATUS_TOPICS):
            node.create_subscription(DiagnosticStatus, topic, self._follow, LATCHED)
        if self._deadline is not None:
            wiring.listen("state", self._store_state)
            steady_timer(node, TICK_S, self._check)

    def reset(self) -> None:
        """Forget all ticks."""
        self._guard.reset()
        self._flown, self._far = None, FarSetpointMonitor()
        if self._deadline is not None:
            self._deadline = InputDeadline(self._guard, self._deadline.params)
        self._stamp_delay = StampDelayMonitor()

    def _follow(self, status: DiagnosticStatus) -> None:
        """Reset the controller when commands begin to be flown."""
        self._end_absent_procedures()
        if self._hand_overs.update(status.name, status.message):
            self._guard.begin_flight()
            if self._deadline is not None:  # a setpoint of before, as on the ground, is no place to hover
                self._deadline = InputDeadline(self._guard, self._deadline.params)

    def _end_absent_procedures(self) -> None:
        publishing = publishers_of(self._node, STATUS_TOPIC)
        self._hand_overs.end_absent({reporter_name(f"/{node}") for node in publishing})

    def _look_for_far_setpoints(self) -> None:
        """Log vehicles in flight that are far from their setpoints."""
        self._end_absent_procedures()
        if not self._hand_overs.flying:
            self._far, self._wiring.health.doubts["setpoints"] = FarSetpointMonitor(), ""
        elif self._flown is not None:
            message, new = self._far.update(*self._flown, self._changes.brought_down)
            self._wiring.health.doubts["setpoints"] = message
            if new:
                self._node.get_logger().warning(message)

    def _lateness(self, stamp: float) -> float:
        return self._stamp_delay.lateness(stamp, monotonic())

    def _store_state(self, _: int, state: Signal) -> None:
        if isinstance(state, SwarmState):
            self._state = state

    def _count(self, _: int, command: SwarmCommand) -> None:
        fallen = int(command.status.max(initial=0)) > SATURATED
        self._wiring.health.fallbacks += fallen
        if fallen or self._changes.active:
            self._log_changes(command)

    def _check(self) -> None:
        """Send the command that is due."""
        if self._deadline is not None:
            self._send(self._deadline.due(self._state, monotonic()))

    def _send(self, command: SwarmCommand | None) -> None:
        if command is not None:
            self._wiring.publish(stamp_from_time(command.t), command)
            self._wiring.health.fallbacks += 1
            self._log_changes(command)

    def _on_emergency(self, _: Empty.Request, response: Empty.Response) -> Empty.Response:
        command = self._guard.cut_all()
        if command is not None:
            self._changes.update(command, self._guard.flights)  # logged here, for all vehicles in one line
        self._send(command)
        self._wiring.health.failure = EMERGENCY_CUT
        self._node.get_logger().error(EMERGENCY_CUT)
        return response

    def _log_changes(self, command: SwarmCommand) -> None:
        """Log the fallback phases that begin with a command; keep the present ones."""
        log, health = self._node.get_logger(), self._wiring.health
        for change in self._changes.update(command, self._guard.flights):
            if change.phase is CommandStatus.CUT:
                log.error(cut_reason(change.names, emergency=self._guard.emergency))
            else:
                log.warning(str(change))
        health.fallback = str(self._changes)
        health.failure = self._failure()

    def _failure(self) -> str:
        if self._guard.emergency:
            return EMERGENCY_CUT
        return cut_reason(self._changes.cut, emergency=False) if self._changes.cut else ""
