"""Wiring common to `pid`, `mpc` and `own_controller`: parameters, inputs, guard, `command`, legacy topics.

`<name>/cmd_vel_legacy` has the signs of Crazyswarm2's default server, cpp: linear.x is pitch, nose down, and
linear.y roll, to the right [deg], angular.z yaw rate, to the right [deg/s], linear.z thrust [PWM]. For the
server cflib, which takes the opposite pitch, set `legacy_hz:=0` and run `crazyswarm` with `backend:=cflib`.
"""

from dataclasses import dataclass

from geometry_msgs.msg import Twist, Vector3
from rclpy.node import Node

from q2q_control.controller import Controller
from q2q_control.crazyswarm.message_conversion import DEFAULT_BACKEND, legacy_twists
from q2q_control.failsafe.fallback_params import FallbackParams
from q2q_control.radio.link.rpyt_scale import RpytScale
from q2q_control.ros.guarded_commands import GuardedCommands
from q2q_model.ros.node.input_warnings import AbsentNames, warn_of_missing_names
from q2q_model.ros.node.node_parameters import declare
from q2q_model.ros.node.tick_wiring import TickWiring
from q2q_model.ros.topics.vehicle_publishers import VehiclePublishers
from q2q_model.signals.layout import Signal
from q2q_model.signals.values import (
    Interference,
    Names,
    SwarmCommand,
    SwarmSetpoint,
    SwarmState,
    check_unique,
)
from q2q_model.tunable import check_bounds, tunable
from q2q_model.vehicle.constants import Vehicle
from q2q_model.vehicle.thrust_map import FIRMWARES, STOCK


@dataclass(frozen=True, slots=True)
class ControllerNodeParams:
    """Parameters of a controller node, without the controller's."""

    vehicle: str = tunable(
        "crazyflie_2_0", "vehicle type, whose constants the controller uses", read_only=True
    )
    firmware: str = tunable(
        STOCK, "firmware of the vehicles, which determines thrust per PWM", choices=FIRMWARES, read_only=True
    )
    vehicles: tuple[str, ...] = tunable(
        (), "names of the vehicles to command; empty: all in the setpoints", read_only=True
    )
    aware: bool = tunable(default=True, description="compensate the predicted downwash", read_only=True)
    live: bool = tunable(
        default=False,
        description="monitor the wall clock, and fall back if a tick does not arrive in time",
        read_only=True,
    )
    legacy_hz: float = tunable(
        10.0,
        "largest rate of <name>/cmd_vel_legacy, with the signs of Crazyswarm2's server cpp; 0: not published",
        unit="Hz",
        low=0.0,
        high=1000.0,
        read_only=True,
    )

    def __post_init__(self) -> None:
        """Check the bounds."""
        check_bounds(self)
        check_unique(self.vehicles)


@dataclass(frozen=True, slots=True)
class CorrectionNodeParams:
    """Parameters of the nodes of controllers that can correct the predicted downwash."""

    correct: bool = tunable(
        default=False,
        description="correct the predicted downwash by measured positions and accelerometers (topic imu)",
        read_only=True,
    )


class LegacyTopics:
    """Publishers of `<name>/cmd_vel_legacy`."""

    def __init__(self, node: Node, scale: RpytScale, rate_hz: float, names: Names) -> None:
        """Publish at most `rate_hz` times per second; `names` are the vehicles known in advance."""
        self._scale = scale
        self._writers = VehiclePublishers(node, {"cmd_vel_legacy": Twist}, rate_hz, names)

    def publish(self, stamp_ns: int, command: SwarmCommand) -> None:
        """Publish the command of every vehicle, if one is due."""
        if not self._writers.due(command.t, stamp_ns, command.names):
            return
        rows = legacy_twists(command, self._scale, DEFAULT_BACKEND).tolist()
        for name, (x, y, yaw_rate, pwm) in zip(command.names, rows, strict=True):
            for writer in self._writers.with_subscribers(name, stamp_ns):
                writer.publish(Twist(linear=Vector3(x=x, y=y, z=pwm), angular=Vector3(z=yaw_rate)))


def wire_controller(
    node: Node,
    params: ControllerNodeParams,
    vehicle: Vehicle,
    controller: Controller,
) -> tuple[TickWiring[SwarmCommand], GuardedCommands]:
    """Return the wiring of a tick, not yet started, and the guard of the controller."""
    inputs: dict[str, type[Signal]] = {"state": SwarmState, "reference_safe": SwarmSetpoint}
    if params.aware:
        inputs["interference"] = Interference
    wiring = TickWiring(node, inputs, ("command", SwarmCommand), shares_output=bool(params.vehicles))
    scale = RpytScale(vehicle.full_pwm_thrust)
    wiring.after_publish(LegacyTopics(node, scale, params.legacy_hz, params.vehicles).publish)
    for topic in ("state", "reference_safe"):
        wiring.listen(topic, warn_of_missing_names(node, topic, params.vehicles))
    why = "reference_safe: {}: check that the plan is for these vehicles"
    unmeasured = AbsentNames(node, "state", why, wiring.health)
    wiring.listen("state", lambda _, state: unmeasured.take_source(state.names))
    wiring.listen("reference_safe", unmeasured.update)
    fallback = declare(node, FallbackParams())
    guarded = GuardedCommands(controller, fallback, vehicle.hover_thrust, live=params.live)
    guarded.wire(node, wiring)
    return wiring, guarded
