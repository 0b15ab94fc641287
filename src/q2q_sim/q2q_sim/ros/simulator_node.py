"""Simulator node: motion capture out, commands in over the simulated radio, vehicles in between.

| pace | source of time |
|---|---|
| lockstep | the command of the tick: the same seed gives the same flight, faster than real time |
| live | the wall clock, 100 Hz |

With `crtp` the vehicles fly by their own firmware under CRTP clients (docs/real_vehicles.md): live, until the
node is ended; `command` is not read.
"""

import json
from dataclasses import dataclass
from time import perf_counter
from typing import TYPE_CHECKING

from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String
from std_srvs.srv import Trigger

from q2q_model.node.health import Health
from q2q_model.ros.node.diagnostics import publish_health
from q2q_model.ros.node.node_parameters import declare
from q2q_model.ros.node.run import run
from q2q_model.ros.node.steady_timer import steady_timer
from q2q_model.ros.topics.messages import MESSAGES
from q2q_model.ros.topics.qos import LATCHED, TICK, TICK_WRITER
from q2q_model.signals.cdr import SignalReader, encode, encode_stamp, header_stamp_ns
from q2q_model.signals.layout import Signal
from q2q_model.signals.values import Interference, MocapFrame, SwarmCommand, SwarmImu, SwarmState
from q2q_model.tunable import check_bounds, tunable
from q2q_model.vehicle.constants import VEHICLES
from q2q_model.vehicle.thrust_map import FIRMWARES
from q2q_sim.loop.flight_clock import FlightClock, as_fields
from q2q_sim.loop.lockstep import CommandGate, Patience
from q2q_sim.loop.room import TICK_S, Room, Tick
from q2q_sim.scenarios import library
from q2q_sim.scenarios.choices import WAKES
from q2q_sim.scenarios.scenario import Scenario, with_choices, with_firmware

if TYPE_CHECKING:
    from q2q_sim.crtp.udp_endpoint import CrtpEndpoint

STALL_LOOK_S = 0.05
"""Period of the check for stalled ticks [s]."""
OUTPUTS = {
    "mocap": MocapFrame,
    "truth": SwarmState,
    "truth_interference": Interference,
    "imu": SwarmImu,
}


@dataclass(frozen=True, slots=True)
class SimulatorParams:
    """Parameters of the node."""

    scenario: str = tunable("table6", "scenario name or file", read_only=True)
    vehicle: str = tunable(
        "", "vehicle constants; empty is the scenario's", choices=("", *VEHICLES), read_only=True
    )
    wake: str = tunable("", "true wake; empty is the scenario's", choices=("", *WAKES), read_only=True)
    firmware: str = tunable(
        "", "thrust per PWM; empty is the scenario's", choices=("", *FIRMWARES), read_only=True
    )
    seed: int = tunable(0, "random seed", low=0, read_only=True)
    pace: str = tunable("lockstep", "source of time", choices=("lockstep", "live"), read_only=True)
    autostart: bool = tunable(True, "fly at once; else wait for ~/start", read_only=True)  # noqa: FBT003
    crtp: bool = tunable(False, "let CRTP clients fly the vehicles instead of commands", read_only=True)  # noqa: FBT003
    again_s: float = tunable(
        5.0,
        "lockstep: publish an unanswered frame again after",
        unit="s",
        low=0.01,
        high=60.0,
        read_only=True,
    )
    give_up_s: float = tunable(
        10.0, "lockstep: fly on without a command after", unit="s", low=0.01, high=3600.0, read_only=True
    )

    def __post_init__(self) -> None:
        """Check the bounds."""
        check_bounds(self)


class Simulator:
    """Room and its topics."""

    def __init__(self, node: Node) -> None:
        self._params = declare(node, SimulatorParams())
        flown = with_choices(library.load(self._params.scenario), self._params.vehicle, self._params.wake)
        self._scenario = with_firmware(flown, self._params.firmware)
        rehearse(self._scenario)
        self._room = Room(self._scenario, self._params.seed)
        self._gate = CommandGate(self._scenario.names, exact=self._params.pace == "lockstep")
        self._patience = Patience(self._params.again_s, self._params.give_up_s)
        self._clock = FlightClock()
        self._health = Health()
        self._crtp = self._opened(node) if self._params.crtp else None
        self._flying = False
        self._command: SwarmCommand | None = None
        self._tick: Tick | None = None
        self._wire(node)

    def _opened(self, node: Node) -> "CrtpEndpoint":
        from q2q_sim.ros.crtp_room import open_crtp, rehearse_crtp  # firmware that other rooms are spared

        rehearse_crtp(self._scenario)
        return open_crtp(node, self._room, self._scenario, self._health)

    def _wire(self, node: Node) -> None:
        self._node = node
        self._reader = SignalReader(SwarmCommand)
        self._writers = {
            topic: node.create_publisher(MESSAGES[kind], topic, TICK_WRITER)
            for topic, kind in OUTPUTS.items()
        }
        self._clock_writer = node.create_publisher(Clock, "/clock", TICK)
        self._summary = node.create_publisher(String, "flight_summary", LATCHED)
        if self._crtp is None:
            node.create_subscription(MESSAGES[SwarmCommand], "command", self._on_command, TICK, raw=True)
        node.create_service(Trigger, "~/start", self._on_start)
        live = self._params.pace == "live" or self._crtp is not None
        steady_timer(node, TICK_S if live else STALL_LOOK_S, self._on_beat if live else self._on_stall)
        publish_health(node, self._health, self._clock.recent)
        if self._params.autostart:
            self._start()

    def _on_start(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.success = not self._flying
        response.message = "already flying" if self._flying else "flying"
        if not self._flying:
            self._start()
        return response

    def _start(self) -> None:
        self._flying = True
        self._clock.start(perf_counter())
        self._show_tick()

    def _show_tick(self) -> None:
        self._tick = self._room.capture()
        self._gate.expect(self._tick.frame_stamp_ns)
        now = perf_counter()
        self._patience.begin(now)
        self._clock.frame_out(now)
        self._publish_frame(self._tick)
        self._publish("truth", self._tick.truth, self._tick.stamp_ns)
        self._publish("truth_interference", self._tick.truth_interference, self._tick.stamp_ns)
        self._publish("imu", self._tick.imu, self._tick.stamp_ns)
        self._clock_writer.publish(encode_stamp(self._tick.stamp_ns))

    def _publish_frame(self, tick: Tick) -> None:
        self._publish("mocap", tick.frame, tick.frame_stamp_ns)

    def _publish(self, topic: str, signal: Signal, stamp_ns: int) -> None:
        self._writers[topic].publish(encode(signal, stamp_ns))

    def _on_command(self, data: bytes) -> None:
        try:
            whole = self._gate.offer(header_stamp_ns(data), self._reader.read(data))
        except ValueError as refusal:
            self._refuse(refusal)
            return
        if whole is None or not self._flying or self._command is not None:
            return
        self._clock.command_in(perf_counter())
        self._patience.answered()
        self._command = whole
        if self._params.pace == "lockstep":
            self._advance()

    def _refuse(self, refusal: ValueError) -> None:
        self._health.refuse(f"command: {refusal}")
        self._node.get_logger().error(f"command refused: {refusal}", throttle_duration_sec=1.0)

    def _on_beat(self) -> None:
        if self._flying:
            self._advance()

    def _on_stall(self) -> None:
        now = perf_counter()
        if not self._flying or self._tick is None:
            return
        if self._patience.gives_up(now):
            self._advance()
        elif self._patience.asks_again(now):
            self._publish_frame(self._tick)

    def close(self) -> None:
        """Close the ports of CRTP clients."""
        if self._crtp is not None:
            self._crtp.close()

    def _advance(self) -> None:
        if self._crtp is not None:
            self._room.fly(self._crtp.fly)
            self._health.ticks += 1
            self._show_tick()
            return
        if self._command is None:
            self._clock.missed()
            self._health.missed += 1
        try:
            self._room.advance(self._command)
        except ValueError as refusal:  # not finite: the vehicles keep their last setpoint
            self._refuse(refusal)
            self._room.advance(None)
        self._command = None
        self._health.ticks += 1
        if self._room.tick * TICK_S >= self._scenario.duration:
            self._finish()
        else:
            self._show_tick()

    def _finish(self) -> None:
        self._flying = False
        timing = self._clock.timing(perf_counter(), self._room.tick * TICK_S)
        self._summary.publish(String(data=json.dumps(as_fields(timing))))
        self._node.get_logger().info(f"flight over: {timing}")


def rehearse(scenario: Scenario) -> None:
    """Run a temporary room for two ticks, so that the first real tick is not slow."""
    room = Room(scenario, seed=0)
    for _ in range(2):
        room.capture()
        room.advance(None)


def main() -> None:
    """Run the node `simulator`."""
    run("simulator", Simulator, Simulator.close)
