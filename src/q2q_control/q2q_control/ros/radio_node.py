"""Fly vehicles over cflib: `command` or `reference_safe` in, packets out; pose, battery, link quality back.

| mode | inputs | sent every tick |
|---|---|---|
| command | `command`, `state` | roll, pitch, yaw rate, thrust |
| setpoint | `reference_safe`, `state`, and `interference` if aware | full state with acc = acc_ref - eta |

Vehicles fly by one procedure (q2q_control.flight_procedure.procedure): `~/take_off`, `~/fly`, `~/hold`,
`~/land`, `~/emergency` (motors off, for good; `~/stop` is another name of it, and in setpoint mode, where no
controller has it, `all/emergency`). Each answers what has happened, or why not; `~/status` tells the step.
`~/start` is for vehicles that are held at their setpoints. q2q_control.radio.radio_pilot says what happens by
itself, as when commands stay away: DDS's word that their writer is gone is one more look, at once. `--dry-
run` sends nothing.
"""

import sys
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
from q2q_control.ros.dry_run import dry_run_as_parameter
from q2q_control.ros.guarded_commands import EMERGENCY
from q2q_control.ros.procedure_services import ProcedureServices
from q2q_control.ros.radio_topics import RadioTopics
from q2q_model.node.health import Health
from q2q_model.ros.node.diagnostics import publish_health
from q2q_model.ros.node.node_parameters import declare
from q2q_model.ros.node.run import run
from q2q_model.ros.node.steady_timer import steady_timer
from q2q_model.ros.topics.deadlines import watch
from q2q_model.ros.topics.listening import listener
from q2q_model.ros.topics.messages import MESSAGES
from q2q_model.ros.topics.qos import TICK
from q2q_model.signals.layout import Signal
from q2q_model.signals.values import SwarmState
from q2q_model.vehicle.constants import vehicle_by_name

WATCH_S = 0.02
"""How often links and batteries are looked at [s]."""

SETTLE_S = 0.5
"""From the end of a landing's polynomial to standing on the ground [s]."""


class RadioNode:
    """Links, pilot and procedure of the vehicles, and the signals that are passed on to them."""

    def __init__(self, node: Node) -> None:
        """Open the links.

        Raises:
            ValueError: no vehicles, a wrong file or parameter, cflib is missing.
            OSError: a file cannot be read.
        """
        self._node = node
        self._asked = asked = declare(node, RadioNodeParams())
        limits, landing = declare(node, RadioPilotParams()), declare(node, LandingParams())
        vehicle = vehicle_by_name(asked.vehicle, asked.firmware)
        self._scale = LegacyScale(vehicle.full_pwm_thrust)
        self._links = open_links(asked)
        hover = level_rpyt(vehicle.hover_thrust, self._scale)
        self._pilot = RadioPilot(self._links, limits, hover if asked.mode == "command" else None, landing)
        self._silent_s = limits.silent_s
        self._health = Health()
        self._ticks = FlownTicks(asked.mode, self._health, aware=asked.aware)
        self._topics = RadioTopics(node, tuple(self._links), asked.pose_hz)
        executor = RadioExecutor(self._pilot, self._links, vehicle)
        self._services = ProcedureServices(
            node, tuple(self._links), executor, (declare(node, FlightProcedureParams()), landing)
        )
        self._services.guard = self._other_radios
        self._ticks.procedure = self._services
        self._subscribe()
        node.create_service(Trigger, "~/stop", self._on_stop)
        steady_timer(node, WATCH_S, self._watch)
        if asked.mode == "setpoint":
            node.create_service(Empty, EMERGENCY, self._on_emergency)
        publish_health(node, self._health)

    def close(self) -> None:
        """Let flying vehicles land, then close the links: cflib's last packet stops the motors."""
        if self._pilot.land(monotonic()):
            sleep(self._pilot.landing_s + SETTLE_S)
        for link in self._links.values():
            link.close()

    def _subscribe(self) -> None:
        for topic, signal in tick_topics(self._asked.mode, aware=self._asked.aware).items():
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
            self._pilot.places(value, now, send=self._asked.places)
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
            for line in link.said():
                self._node.get_logger().info(f"{name}: {line}")
        for line in self._pilot.said():
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


def open_links(asked: RadioNodeParams) -> dict[str, CflibLink]:
    """Return a link to every vehicle, by name.

    Raises:
        ValueError: no vehicles, a wrong file or parameter, cflib is missing.
        OSError: a file cannot be read.
    """
    params = firmware_params(asked.firmware_params, asked.mode)
    return {one.name: CflibLink(one.name, one.uri, params, asked.toc_cache) for one in _crazyflies(asked)}


def _crazyflies(asked: RadioNodeParams) -> tuple[Crazyflie, ...]:
    if asked.crazyflies:
        return crazyflies_from_document(yaml.safe_load(Path(asked.crazyflies).read_text(encoding="utf-8")))
    return crazyflies_at(asked.vehicles, asked.uris)


def main() -> None:
    """Run the node `radio`; `--dry-run` is its parameter dry_run."""
    sys.argv = dry_run_as_parameter(sys.argv)
    run("radio", RadioNode, RadioNode.close)
