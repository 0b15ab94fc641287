"""Wiring of the node `radio`: topics and services around its vehicles."""

from time import monotonic, sleep

from rclpy.node import Node
from std_srvs.srv import Empty

from q2q_control.flight_procedure.procedure_params import FlightProcedureParams, LandingParams
from q2q_control.flight_procedure.steps import Call
from q2q_control.radio.pilot.pilot_params import RadioPilotParams
from q2q_control.radio.radio_params import RadioNodeParams
from q2q_control.radio.radio_vehicles import WATCH_S, RadioVehicles
from q2q_control.ros.guarded_commands import EMERGENCY
from q2q_control.ros.procedure_services import ProcedureServices
from q2q_control.ros.radio_topics import RadioTopics
from q2q_model.diagnostics.health import Health
from q2q_model.ros.node.diagnostics_publisher import publish_health
from q2q_model.ros.node.node_parameters import declare
from q2q_model.ros.node.publisher_conflicts import PublisherConflicts
from q2q_model.ros.node.steady_timer import steady_timer
from q2q_model.ros.topics.subscriptions import subscribe_signals
from q2q_model.signals.layout import Signal


class RadioNode:
    """Vehicles, flight procedure and topics of a node."""

    def __init__(self, node: Node) -> None:
        """Open the links.

        Raises:
            ValueError: no vehicles, a wrong file or parameter, cflib is missing.
            OSError: a file cannot be read.
        """
        self._node = node
        params, health = declare(node, RadioNodeParams()), Health()
        limits, landing = declare(node, RadioPilotParams()), declare(node, LandingParams())
        procedure = declare(node, FlightProcedureParams()), landing
        self._vehicles = RadioVehicles(params, limits, procedure, health)
        for line in self._vehicles.settings:
            node.get_logger().info(line)
        self._topics = RadioTopics(node, self._vehicles.names, params.pose_hz)
        self._services = ProcedureServices(
            node,
            self._vehicles.names,
            self._vehicles.executor,
            procedure,
        )
        self._inputs = PublisherConflicts(node, self._vehicles.ticks.topics, health)
        self._services.refuse_flights(self._conflicts)
        self._vehicles.ticks.procedure = self._services
        subscribe_signals(node, self._vehicles.ticks.topics, self._take, health)
        self._services.offer_also("stop", Call.EMERGENCY)
        steady_timer(node, WATCH_S, self._watch)
        if params.mode == "setpoint" or procedure[0].dry_run:
            node.create_service(Empty, EMERGENCY, self._on_emergency)
        publish_health(node, health, self._facts)

    def land(self) -> float:
        """Land flying vehicles; return the time until all are down [s]."""
        return self._vehicles.land(monotonic())

    def close(self) -> None:
        """Close the links, whose vehicles are down, except after an error while they landed."""
        sleep(self.land())
        self._vehicles.close()

    def _take(self, topic: str, stamp_ns: int, value: Signal) -> None:
        self._vehicles.take(topic, stamp_ns, value, monotonic())

    def _watch(self) -> None:
        for line in self._vehicles.watch(monotonic()):
            self._node.get_logger().info(line)
        for name, link in self._vehicles.links.items():
            self._topics.publish(name, link.health(), link.pose)

    def _facts(self) -> dict[str, str]:
        self._inputs.update()
        return self._vehicles.phases()

    def _conflicts(self) -> str:
        others = self._topics.other_radios()
        return f"another radio node runs: {others}" if others else self._inputs.update()

    def _on_emergency(self, _: Empty.Request, response: Empty.Response) -> Empty.Response:
        self._services.emergency()
        return response
