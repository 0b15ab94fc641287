"""Stand between our nodes and Crazyswarm2: poses in and out, setpoints out, services as clients.

| topic or service | way | made of |
|---|---|---|
| `poses_in` (NamedPoseArray) | in | `mocap` |
| `poses_out` (NamedPoseArray, offers a deadline of 10 ms) | out | `state`, measured vehicles only |
| `<name>/cmd_full_state` (FullState) | out | `reference_safe`, less `interference`'s acceleration if aware |
| `<name>/cmd_vel_legacy` (Twist) | out, where mode is command | `command`; signs by `backend` |
| `all/arm`, `takeoff`, `land`, `notify_setpoints_stop`, `emergency` | out, as a client | the procedure |
| `<name>/status`, `<name>/onboard`, the server's parameters | in | checks before a take-off |

Vehicles fly by one procedure (q2q_control.flight_procedure.procedure): `~/take_off`, `~/fly`, `~/hold`,
`~/land`, `~/emergency`, each answered when it has happened, or with why it has not; `~/status` tells the
step, and what cannot be checked because the server does not tell it. Setpoints leave only from the hand-over
after `~/fly` to the landing. `~/arm`, `~/disarm` and `~/notify_setpoints_stop` pass a request on to the
server, on the ground only. A package that is absent switches off what needs it, with one line. Set
`legacy_hz:=0` on the controller where this node sends `cmd_vel_legacy`. `--dry-run` sends nothing.
"""

import sys
from collections.abc import Callable
from pathlib import Path

import yaml
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy

from q2q_control.crazyswarm.crazyflies import crazyflies_from_document, params_set
from q2q_control.crazyswarm.crazyswarm_params import CrazyswarmParams
from q2q_control.crazyswarm.message_conversion import frame_of, poses_of
from q2q_control.crazyswarm.server_vehicle import ServerVehicle
from q2q_control.flight_procedure.flown_ticks import FlownTicks
from q2q_control.flight_procedure.procedure_params import FlightProcedureParams, LandingParams
from q2q_control.flight_procedure.steps import Act
from q2q_control.radio.firmware_params import firmware_params
from q2q_control.radio.rpyt_scale import LegacyScale
from q2q_control.ros.crazyswarm_commands import CrazyswarmCommands
from q2q_control.ros.crazyswarm_executor import CrazyswarmExecutor
from q2q_control.ros.crazyswarm_types import PosesMessage, PoseTypes, find_pose_types
from q2q_control.ros.dry_run import dry_run_as_parameter
from q2q_control.ros.procedure_services import ProcedureServices
from q2q_model.node.health import Health
from q2q_model.ros.node.diagnostics import publish_health
from q2q_model.ros.node.node_parameters import declare
from q2q_model.ros.node.run import run
from q2q_model.ros.topics.listening import listener
from q2q_model.ros.topics.messages import MESSAGES, header_at
from q2q_model.ros.topics.qos import OUTSIDE, TICK
from q2q_model.signals.cdr import encode
from q2q_model.signals.layout import Signal
from q2q_model.signals.stamps import stamp_from_parts
from q2q_model.signals.values import MocapFrame, Names, SwarmState
from q2q_model.vehicle.constants import vehicle_by_name

POSES_OUT = QoSProfile(
    depth=1, reliability=ReliabilityPolicy.BEST_EFFORT, deadline=Duration(nanoseconds=10_000_000)
)
"""Crazyswarm2's servers ask for a deadline of 10 ms: a writer that offers none reaches no one."""


class Crazyswarm:
    """Hold the topics of both sides."""

    def __init__(self, node: Node) -> None:
        """Wire what the installed packages allow.

        Raises:
            ValueError: no vehicles, or a wrong file or parameter.
            OSError: a file cannot be read.
        """
        self._node = node
        self._asked = declare(node, CrazyswarmParams())
        self._names = _names(self._asked)
        self._health = Health()
        self._ticks = FlownTicks(self._asked.mode, self._health, aware=self._asked.aware)
        self._poses: PoseTypes | None = None
        self._params = declare(node, FlightProcedureParams()), declare(node, LandingParams())
        self._try(self._wire_poses)
        self._try(self._wire_commands)
        self._try(self._wire_procedure)
        publish_health(node, self._health)

    def _try(self, wire: Callable[[], None]) -> None:
        """Wire a part, or say why it is off."""
        try:
            wire()
        except ImportError as missing:
            self._node.get_logger().warning(str(missing))
            self._health.extra["off"] = f"{self._health.extra.get('off', '')} {missing}".strip()

    def _wire_poses(self) -> None:
        if not (self._asked.poses_in or self._asked.poses_out):
            return
        types = find_pose_types()
        if self._asked.poses_in:
            self._mocap = self._node.create_publisher(MESSAGES[MocapFrame], "mocap", TICK)
            heard = find_pose_types(self._asked.poses_version).array
            self._node.create_subscription(heard, self._asked.poses_in, self._on_poses, OUTSIDE)
        if self._asked.poses_out:
            self._out = self._node.create_publisher(types.array, self._asked.poses_out, POSES_OUT)
        self._poses = types

    def _wire_commands(self) -> None:
        vehicle = vehicle_by_name(self._asked.vehicle, self._asked.firmware)
        scale = LegacyScale(vehicle.full_pwm_thrust)
        self._commands = CrazyswarmCommands(
            self._node, self._names, (scale, self._asked.backend), full_state=self._asked.mode == "setpoint"
        )
        for topic, signal in self._ticks.topics.items():
            self._listen(topic, signal)

    def _wire_procedure(self) -> None:
        executor = CrazyswarmExecutor(self._node, _vehicles(self._asked))
        self._ticks.procedure = desk = ProcedureServices(self._node, self._names, executor, self._params)
        for name, act in (
            ("arm", Act.ARM),
            ("disarm", Act.DISARM),
            ("notify_setpoints_stop", Act.STOP_STREAM),
        ):
            desk.offer(name, act)

    def _listen(self, topic: str, signal: type[Signal]) -> None:
        def take(stamp_ns: int, value: Signal) -> None:
            self._take(topic, stamp_ns, value)

        receive = listener(topic, signal, take, self._health)
        self._node.create_subscription(MESSAGES[signal], topic, receive, TICK, raw=True)

    def _take(self, topic: str, stamp_ns: int, value: Signal) -> None:
        if isinstance(value, SwarmState) and self._asked.poses_out:
            self._send_poses(stamp_ns, value)
        tick = self._ticks.take(topic, stamp_ns, value)
        if tick is None or not tick.flown:
            return
        if tick.command is not None:
            self._commands.send_command(tick.command)
        elif tick.setpoint is not None:
            self._commands.send_setpoint(stamp_ns, tick.setpoint, tick.downwash)

    def _on_poses(self, message: PosesMessage) -> None:
        if self._poses is None:
            return
        stamp = message.header.stamp
        stamp_ns = stamp_from_parts(stamp.sec, stamp.nanosec)
        poses = [self._poses.read(one) for one in message.poses]
        self._mocap.publish(encode(frame_of(stamp_ns, poses, self._names), stamp_ns))

    def _send_poses(self, stamp_ns: int, state: SwarmState) -> None:
        if self._poses is not None:
            self._out.publish(self._poses.write(header_at(stamp_ns), poses_of(state)))


def _names(asked: CrazyswarmParams) -> Names:
    if not asked.crazyflies:
        if not asked.vehicles:
            raise ValueError("no vehicles: set crazyflies:=FILE, or vehicles")
        return asked.vehicles
    return tuple(one.name for one in crazyflies_from_document(_document(asked)))


def _vehicles(asked: CrazyswarmParams) -> tuple[ServerVehicle, ...]:
    vehicle, wanted = vehicle_by_name(asked.vehicle, asked.firmware), firmware_params((), asked.mode)
    by_type = asked.backend == "cpp"
    document = _document(asked)
    return tuple(
        ServerVehicle(
            name, vehicle, wanted, {} if document is None else params_set(document, name, by_type=by_type)
        )
        for name in _names(asked)
    )


def _document(asked: CrazyswarmParams) -> object:
    """Return the content of crazyflies.yaml; None where there is none."""
    if not asked.crazyflies:
        return None
    return yaml.safe_load(Path(asked.crazyflies).read_text(encoding="utf-8"))


def main() -> None:
    """Run the node `crazyswarm`; `--dry-run` is its parameter dry_run."""
    sys.argv = dry_run_as_parameter(sys.argv)
    run("crazyswarm", Crazyswarm)
