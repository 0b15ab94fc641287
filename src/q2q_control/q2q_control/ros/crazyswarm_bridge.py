"""Bridge between q2q and Crazyswarm2: poses in and out, setpoints out, services as clients."""

from collections.abc import Callable

from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy

from q2q_control.crazyswarm.configured_vehicles import poses_version, server_vehicles, vehicle_names
from q2q_control.crazyswarm.crazyswarm_params import CrazyswarmParams
from q2q_control.crazyswarm.message_conversion import duplicate_names, mocap_frame, poses_of
from q2q_control.crazyswarm.pose_topics import DEADLINE_NS, PoseNames, PoseReader, readers_refusal
from q2q_control.flight_procedure.flown_ticks import FlownTicks
from q2q_control.flight_procedure.procedure_params import FlightProcedureParams, LandingParams
from q2q_control.flight_procedure.steps import Act
from q2q_control.radio.link.rpyt_scale import RpytScale
from q2q_control.ros.crazyswarm_commands import CrazyswarmCommands
from q2q_control.ros.crazyswarm_executor import CrazyswarmExecutor
from q2q_control.ros.crazyswarm_types import PosesMessage, PoseTypes, find_pose_types
from q2q_control.ros.procedure_services import ProcedureServices
from q2q_model.counted import listed
from q2q_model.diagnostics.health import Health
from q2q_model.ros.node.diagnostics_publisher import publish_health
from q2q_model.ros.node.node_parameters import declare
from q2q_model.ros.node.publisher_conflicts import PublisherConflicts
from q2q_model.ros.topics.messages import MESSAGES, header_at, stamp_of
from q2q_model.ros.topics.qos import OUTSIDE, TICK
from q2q_model.ros.topics.subscriptions import subscribe_signals
from q2q_model.signals.cdr.cdr_writer import encode
from q2q_model.signals.layout import Signal
from q2q_model.signals.values import MocapFrame, SwarmState
from q2q_model.vehicle.constants import vehicle_by_name

POSES_OUT = QoSProfile(
    depth=1, reliability=ReliabilityPolicy.BEST_EFFORT, deadline=Duration(nanoseconds=DEADLINE_NS)
)
"""QoS of poses_out: Crazyswarm2's servers request a deadline, which the writer must offer."""

DUPLICATE = "given twice: ignored, as either pose may be another vehicle's; check its markers"


class Crazyswarm:
    """Topics of both sides."""

    def __init__(self, node: Node) -> None:
        """Wire what the installed packages allow.

        Raises:
            ValueError: no vehicles, or a wrong file or parameter; no package is installed.
            OSError: a file cannot be read.
        """
        self._node = node
        self._settings = declare(node, CrazyswarmParams())
        self._names = vehicle_names(self._settings)
        self._health = Health()
        self._ticks = FlownTicks(self._settings.mode, self._health, aware=self._settings.aware)
        poses_in = self._settings.poses_in
        inputs = (*self._ticks.topics, *filter(None, [poses_in]))
        self._inputs = PublisherConflicts(node, inputs, self._health)
        self._pose_names = PoseNames(poses_in, self._names)
        self._poses: PoseTypes | None = None
        self._params = declare(node, FlightProcedureParams()), declare(node, LandingParams())
        self._services: ProcedureServices | None = None
        self._landing_s: float | None = None
        self._version = poses_version(self._settings)
        poses = _missing(self._wire_poses, "no poses are passed on")
        flight = _missing(self._wire_flight, "no vehicle can fly")
        self._health.extra["off"] = off = "; ".join(filter(None, (poses, flight)))
        if flight and self._poses is None:
            raise ValueError(off)
        if off:
            node.get_logger().warning(off)
        subscribe_signals(node, self._ticks.topics, self._take, self._health)
        publish_health(node, self._health, self._facts)

    def land(self) -> float:
        """Land flying vehicles where they are; return how long that takes at most [s], 0 once down."""
        if self._services is None:
            return 0.0
        if self._landing_s is None:
            self._landing_s = self._services.land_here()
        return self._landing_s if self._services.comes_down else 0.0

    def _wire_poses(self) -> None:
        if not (self._settings.poses_in or self._settings.poses_out):
            return
        types = find_pose_types()
        if self._settings.poses_in:
            self._mocap = self._node.create_publisher(MESSAGES[MocapFrame], "mocap", TICK)
            kind = find_pose_types(self._version).array
            self._node.create_subscription(kind, self._settings.poses_in, self._on_poses, OUTSIDE)
        if self._settings.poses_out:
            self._out = self._node.create_publisher(types.array, self._settings.poses_out, POSES_OUT)
        self._poses = types

    def _wire_flight(self) -> None:
        """Wire the procedure, without which nothing is flown, then what it lets through."""
        services = self._wire_procedure()
        self._wire_commands()
        services.refuse_flights(
            lambda: (
                self._commands.conflicts()
                or self._inputs.update()
                or self._poses_refusal()
                or self._executor.refusal()
            )
        )

    def _wire_commands(self) -> None:
        vehicle = vehicle_by_name(self._settings.vehicle, self._settings.firmware)
        scale = RpytScale(vehicle.full_pwm_thrust)
        self._commands = CrazyswarmCommands(
            self._node,
            self._names,
            (scale, self._settings.backend),
            full_state=self._settings.mode == "setpoint",
        )

    def _wire_procedure(self) -> ProcedureServices:
        unlock = self._unlock if self._settings.mode == "command" else None
        self._executor = CrazyswarmExecutor(self._node, server_vehicles(self._settings), unlock)
        services = ProcedureServices(self._node, self._names, self._executor, self._params)
        self._ticks.procedure = self._services = services
        for name, act in (
            ("arm", Act.ARM),
            ("disarm", Act.DISARM),
            ("notify_setpoints_stop", Act.STOP_STREAM),
        ):
            services.offer(name, act)
        return services

    def _unlock(self) -> None:
        self._commands.unlock()

    def _facts(self) -> dict[str, str]:
        self._inputs.update()
        self._health.doubts["poses"] = self._poses_refusal()
        if found := self._pose_names.new_mismatch():
            self._node.get_logger().warning(found)
        return {}

    def _poses_refusal(self) -> str:
        """Return what is wrong with the topics of poses, and what to do; empty if nothing is."""
        return self._pose_names.mismatch or self._readers_refusal()

    def _readers_refusal(self) -> str:
        topic = self._settings.poses_out
        if self._poses is None or not topic:
            return ""
        found = self._node.get_subscriptions_info_by_topic(self._node.resolve_topic_name(topic))
        readers = [PoseReader(one.node_name, one.qos_profile.deadline.nanoseconds) for one in found]
        return readers_refusal(topic, readers)

    def _take(self, topic: str, stamp_ns: int, value: Signal) -> None:
        if isinstance(value, SwarmState) and self._settings.poses_out:
            self._send_poses(stamp_ns, value)
        tick = self._ticks.take(topic, stamp_ns, value)
        if tick is None or not tick.flown:
            return
        if tick.command is not None:
            self._executor.take_sent(self._commands.send_command(tick.command))
        elif tick.setpoint is not None:
            sent = self._commands.send_setpoint(stamp_ns, tick.setpoint, tick.downwash)
            self._executor.take_sent(sent)

    def _on_poses(self, message: PosesMessage) -> None:
        if self._poses is None:
            return
        try:
            stamp_ns = stamp_of(message.header)
        except ValueError as refusal:
            self._health.refuse(f"{self._settings.poses_in}: {refusal}")
            return
        poses = [self._poses.read(one) for one in message.poses]
        self._pose_names.take([one.name for one in poses])
        if duplicates := duplicate_names(poses, self._names):
            self._health.refuse(f"{self._settings.poses_in}: {listed(duplicates)} {DUPLICATE}")
        self._mocap.publish(encode(mocap_frame(stamp_ns, poses, self._names), stamp_ns))

    def _send_poses(self, stamp_ns: int, state: SwarmState) -> None:
        if self._poses is not None:
            self._out.publish(self._poses.write(header_at(stamp_ns), poses_of(state)))


def _missing(wire: Callable[[], None], without: str) -> str:
    """Wire a part; return what is missing for it and what does not work `without`, empty if it works."""
    try:
        wire()
    except ImportError as missing:
        return f"{missing}: {without}"
    return ""
