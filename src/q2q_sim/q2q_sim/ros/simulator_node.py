"""Simulator node: vehicles, motion capture and radio: `command` in, `mocap`, `truth` and `imu` out.

| pace | when time advances |
|---|---|
| lockstep | with the command of the tick: the same seed gives the same flight, faster than real time |
| live | by the wall clock, 100 Hz |

With `pace:=live` the flight begins at once, even if other nodes have not discovered this one, and vehicles
that receive no command for 2 s lock their motors. To let it wait until the nodes of the control loop are
ready and connected, and a command has come, give
`-p starts_after:="[mocap_filter, interference, trajectory, replanner, pid]"`. Or give `autostart:=false`,
and call `~/start` once they run.

In one process with the controller (`q2q_sim.ros.stack`), lockstep runs 20 ticks (BURST) at a time; between
them the other callbacks of the process run.

With `crtp:=true`, CRTP clients fly the vehicles through their emulated firmware (docs/emulated_firmware.md),
at 100 Hz of wall time until the node is ended.
"""

from collections import deque
from collections.abc import Mapping
from time import perf_counter
from typing import TYPE_CHECKING

from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String
from std_srvs.srv import Trigger

from q2q_model.ros.node.bus_node import bus_of
from q2q_model.ros.node.diagnostics_publisher import publish_health
from q2q_model.ros.node.node_parameters import declare, withhold_named
from q2q_model.ros.node.publisher_conflicts import TopicConflict, publishers_of
from q2q_model.ros.node.run import run
from q2q_model.ros.node.signal_publisher import SignalPublisher
from q2q_model.ros.node.steady_timer import steady_timer
from q2q_model.ros.topics.messages import MESSAGES
from q2q_model.ros.topics.qos import LATCHED, MANY_WRITERS, TICK, TICK_WRITER
from q2q_model.ros.topics.subscriber_check import SubscriberCheck
from q2q_model.signals.cdr.cdr_writer import encode_stamp
from q2q_model.signals.layout import Signal
from q2q_model.signals.topic_names import FLIGHT_SUMMARY
from q2q_model.signals.values import SwarmCommand
from q2q_sim.link.conflicting_commands import conflict_note
from q2q_sim.loop.command_gate import unknown_vehicles
from q2q_sim.ros.ready_nodes import ReadyNodes
from q2q_sim.simulator.flight_clock import timing_as_text
from q2q_sim.simulator.flight_output import OUTPUTS, Output
from q2q_sim.simulator.room_flight import RoomFlight, warm_up_room
from q2q_sim.simulator.simulator_params import SimulatorParams, chosen_scenario

if TYPE_CHECKING:
    from q2q_sim.crtp.udp_endpoint import CrtpEndpoint


COMMAND, CLOCK, CRTP = "command", "/clock", "crtp"
LOCKED, CONFLICTS, STAMPS, UNKNOWN = "locked", "conflicts", "stamps", "unknown"
"""What has found a doubt."""
BURST = 20
"""Ticks between two turns of the other callbacks; ten vehicles fly them in about 10 ms."""
LOOK_S = 0.05
"""Period of looks for nodes that the start waits for [s]."""
WAITING_S = 5.0
"""Period of log lines about them [s]."""
BURST_PERIOD_S = 0.001
"""Longest wait for the next burst [s]."""


class Simulator:
    """Flight of a room and its topics."""

    def __init__(self, node: Node) -> None:
        self._node = node
        params = declare(node, SimulatorParams())
        scenario = chosen_scenario(params)
        room = warm_up_room(scenario, params.seed)
        self._crtp: CrtpEndpoint | None = None
        if params.crtp:
            from q2q_sim.ros.crtp_room import open_crtp  # firmware that other rooms are spared

            self._crtp = open_crtp(node, room, scenario)
        else:
            withhold_named(node, "crtp_*", "crtp:=true")
        firmware = self._crtp.fly if self._crtp else None
        self._flight = RoomFlight(room, params, scenario.duration, perf_counter, firmware)
        self._names = room.names
        self._controllers = TopicConflict(node, COMMAND, len(room.names))
        self._due: deque[Output] = deque()
        self._writers = {
            topic: SignalPublisher(node, topic, signal, TICK_WRITER) for topic, signal in OUTPUTS.items()
        }
        self._clock = node.create_publisher(Clock, CLOCK, TICK)
        self._clocks = TopicConflict(node, CLOCK)
        self._clock_check = SubscriberCheck((self._clock,))
        self._summary = node.create_publisher(String, FLIGHT_SUMMARY, LATCHED)
        if not params.crtp:
            self._listen()
        node.create_service(Trigger, "~/start", self._on_start)
        steady_timer(node, self._flight.period_s, self._on_timer)
        publish_health(node, self._flight.health, self._diagnostics)
        if params.autostart:
            self._others = ReadyNodes(node, params.starts_after)
            self._look = steady_timer(node, LOOK_S, self._on_look)

    def close(self) -> None:
        """Close the ports of CRTP clients."""
        if self._crtp is not None:
            self._crtp.close()

    def _listen(self) -> None:
        """Take commands from this process, or from another one."""
        bus = bus_of(self._node)
        if bus.carries(COMMAND):
            bus.listen(COMMAND, self._on_own_command)
            steady_timer(self._node, BURST_PERIOD_S, self._on_burst)
        else:
            kind = MESSAGES[SwarmCommand]
            self._node.create_subscription(kind, COMMAND, self._on_command, MANY_WRITERS, raw=True)

    def _on_own_command(self, stamp_ns: int, command: Signal) -> None:
        if isinstance(command, SwarmCommand):
            self._due.append(self._flight.take(stamp_ns, command))

    def _on_burst(self) -> None:
        for _ in range(BURST):
            if not self._due:
                return
            self._publish(self._due.popleft())

    def _on_command(self, data: bytes) -> None:
        self._publish(self._flight.receive(data))

    def _on_timer(self) -> None:
        if not self._due:  # else the tick is not published yet, however late it is
            self._publish(self._flight.on_timer())

    def _on_start(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        refusal = self._flight.refusal
        response.success, response.message = not refusal, refusal or "flying"
        self._publish(self._flight.start())
        return response

    def _on_look(self) -> None:
        """Start the flight once the other nodes are ready."""
        if missing := self._others.missing():
            self._node.get_logger().info(f"waiting: {'; '.join(missing)}", throttle_duration_sec=WAITING_S)
            return
        self._look.cancel()
        self._publish(self._flight.start())

    def _publish(self, output: Output) -> None:
        for topic, signal, stamp_ns in output.signals:
            self._writers[topic].post(stamp_ns, signal)
        if output.clock_ns is not None and self._clock_check.has_subscribers(output.clock_ns):
            self._clock.publish(encode_stamp(output.clock_ns))
        if output.refusal:
            self._node.get_logger().error(f"command refused: {output.refusal}", throttle_duration_sec=1.0)
        if output.gave_up:
            self._node.get_logger().warning(output.gave_up)
        if output.timing is not None:
            self._summary.publish(String(data=timing_as_text(output.timing)))
            self._node.get_logger().info(f"flight over: {output.timing}")

    def _diagnostics(self) -> Mapping[str, str]:
        flight, health = self._flight, self._flight.health
        found = {
            LOCKED: flight.locked,
            CONFLICTS: self._conflicts(),
            STAMPS: flight.misstamped,
            UNKNOWN: unknown_vehicles(flight.conflicts.commanded, self._names),
        }
        for kind, doubt in found.items():
            self._warn_if_new(doubt, health.doubts.get(kind, ""))
        awaited = flight.awaited
        self._warn_if_new(awaited, health.awaited)
        health.awaited = awaited
        health.doubts |= found | {COMMAND: self._controllers.update(), CLOCK: self._clocks.update()}
        if self._crtp is None:
            return flight.clock.recent()
        health.doubts[CRTP] = self._crtp.warnings()
        return {**flight.clock.recent(), **self._crtp.diagnostics()}

    def _warn_if_new(self, found: str, before: str) -> None:
        if found and found != before:
            self._node.get_logger().warning(found)

    def _conflicts(self) -> str:
        """Return which vehicles two nodes command, and what to do; empty for none."""
        vehicles = self._flight.conflicts.take_conflicts()
        return conflict_note(vehicles, publishers_of(self._node, COMMAND)) if vehicles else ""


def main() -> None:
    """Run the node `simulator`."""
    run("simulator", Simulator, Simulator.close)
