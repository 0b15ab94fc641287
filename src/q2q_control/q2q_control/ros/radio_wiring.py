"""Wiring of the node `radio`: links, pilot, flight procedure and topics."""

from pathlib import Path
from time import monotonic, sleep

import yaml
from rclpy.node import Node
from std_srvs.srv import Empty, Trigger

from q2q_control.crazyswarm.crazyflies import Crazyflie, crazyflies_at, crazyflies_from_document
from q2q_control.flight_procedure.flown_ticks import FlownTicks, tick_topics
from q2q_control.flight_procedure.procedure_params import FlightProcedureParams, LandingParams
from q2q_control.flight_procedure.steps import Call
from q2q_control.radio.cflib_link import CflibLink
from q2q_control.radio.firmware_params import firmware_params
from q2q_control.radio.node_params import RadioNodeParams
from q2q_control.radio.pilot_params import RadioPilotParams
from q2q_control.radio.radio_executor import RadioExecutor
from q2q_control.radio.radio_pilot import RadioPilot
from q2q_control.radio.rpyt_scale import LegacyScale
from q2q_control.radio.setpoints import full_states, level_rpyt, names_cut, rpyt_setpoints
from q2q_control.ros.guarded_commands import EMERGENCY
from q2q_control.ros.procedure_services import ProcedureServices
from q2q_control.ros.radio_topics import RadioTopics
from q2q_model.node.health import Health
from q2q_model.ros.node.diagnostics import publish_health
from q2q_model.ros.node.node_parameters import declare
from q2q_model.ros.node.steady_timer import steady_timer
from q2q_model.ros.topics.deadlines import watch
from q2q_model.ros.topics.listening import listener
from q2q_model.ros.topics.messages import MESSAGES
from q2q_model.ros.topics.qos import TICK
from q2q_model.signals.layout import Signal
from q2q_model.signals.values import SwarmState
from q2q_model.vehicle.constants import vehicle_by_name

WATCH_S = 0.02
"""Period of checking links and batteries [s]."""

SETTLE_S = 0.5
"""Time from the end of a landing's polynomial to rest on the ground [s]."""


class RadioNode:
    """Links, pilot, flight procedure and topics of a node."""

    def __init__(self, node: Node) -> None:
        """Open the links.

        Raises:
            ValueError: no vehicles, a wrong file or parameter, cflib is missing.
            OSError: a file cannot be read.
        """
        self._node = node
        self._params = params = declare(node, RadioNodeParams())
        limits, landing = declare(node, RadioPilotParams()), declare(node, LandingParams())
        vehicle = vehicle_by_name(params.vehicle, params.firmware)
        self._scale = LegacyScale(vehicle.full_pwm_thrust)
        self._links = open_links(params)
        hover = level_rpyt(vehicle.hover_thrust, self._scale)
        self._pilot = RadioPilot(self._links, limits, hover if params.mode == "command" else None, landing)
        self._silent_s = limits.silent_s
        self._health = Health()
        self._ticks = FlownTicks(params.mode, self._health, aware=params.aware)
        self._topics = RadioTopics(node, tuple(self._links), params.pose_hz)
        executor = RadioExecutor(self._pilot, self._links, vehicle)
        self._services = ProcedureServices(
            node, tuple(self._links), executor, (declare(node, FlightProcedureParams()), landing)
        )
        self._services.guard = self._other_radios
        self._ticks.procedure = self._services
        self._subscribe()
        node.create_service(Trigger, "~/stop", self._on_stop)
        steady_timer(node, WATCH_S, self._watch)
        if params.mode == "setpoint":
            node.create_service(Empty, EMERGENCY, self._on_emergency)
        publish_health(node, self._health)

    def close(self) -> None:
        """Land flying vehicles, then close the links: cflib's last packet stops the motors."""
        if self._pilot.land(monotonic()):
            sleep(self._pilot.landing_s + SETTLE_S)
        for link in self._links.values():
            link.close()

    def _subscribe(self) -> None:
        for topic, signal in tick_topics(self._params.mode, aware=self._params.aware).items():
            watch(self._node, topic, signal, self._silent_s, self._on_silence)
        for topic, signal in self._ticks.topics.items():
            self._listen(topic, signal)

    def _listen(self, topic: str, signal: type[Signal]) -> None:
        def take(stamp_ns: int, value: Signal) -> None:
            self._take(topic, stamp_ns, value)

        receive = listener(topic, signal, take, self._health)
        self._node.create_subscription(MESSAGES[signal], topic, receive, TICK, raw=True)

    def _take(self, topic: str, stamp_ns: int, value: Signal) -> None:
        tick, now = self._ticks.take(topic, stamp_ns, value), monotonic()
        if isinstance(value, SwarmState):
            self._pilot.update_state(value, now, send=self._params.places)
        if tick is not None and tick.command is not None:
            self._pilot.cut(names_cut(tick.command), now)
            if tick.flown:
                self._pilot.fly_rpyt(tick.command.names, rpyt_setpoints(tick.command, self._scale), now)
        elif tick is not None and tick.setpoint is not None and tick.flown:
            self._pilot.fly_full_states(tick.setpoint.names, full_states(tick.setpoint, tick.downwash), now)

    def _on_silence(self) -> None:
        self._pilot.watch(monotonic(), WATCH_S)

    def _watch(self) -> None:
        self._pilot.watch(monotonic())
        for name, link in self._links.items():
            link.keep_open()
            self._topics.publish(name, link.health(), link.pose)
            for line in link.log_lines():
                self._node.get_logger().info(f"{name}: {line}")
        for line in self._pilot.log_lines():
            self._node.get_logger().info(line)
        self._health.extra |= {f"phase_{name}": phase.value for name, phase in self._pilot.phases.items()}

    def _other_radios(self, call: Call) -> str:
        others = "" if call is Call.EMERGENCY else self._topics.other_radios()
        return f"another radio node runs: {others}" if others else ""

    def _on_emergency(self, _: Empty.Request, response: Empty.Response) -> Empty.Response:
        self._services.emergency()
        return response

    def _on_stop(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._services.emergency()
        response.success, response.message = True, "motors stopped; restart the vehicles"
        return response


def open_links(params: RadioNodeParams) -> dict[str, CflibLink]:
    """Return a link to every vehicle, by name.

    Raises:
        ValueError: no vehicles, a wrong file or parameter, cflib is missing.
        OSError: a file cannot be read.
    """
    firmware = firmware_params(params.firmware_params, params.mode)
    return {one.name: CflibLink(one.name, one.uri, firmware, params.toc_cache) for one in _crazyflies(params)}


def _crazyflies(params: RadioNodeParams) -> tuple[Crazyflie, ...]:
    if params.crazyflies:
        return crazyflies_from_document(yaml.safe_load(Path(params.crazyflies).read_text(encoding="utf-8")))
    return crazyflies_at(params.vehicles, params.uris)
