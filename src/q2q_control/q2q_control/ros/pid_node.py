"""PID node: `state`, `reference_safe` and (if aware) `interference` in, `command` out."""

from dataclasses import dataclass

from rclpy.node import Node

from q2q_control.failsafe.ladder import FallbackParams
from q2q_control.pid.pid import Pid, PidParams
from q2q_control.radio.rpyt_scale import LegacyScale
from q2q_control.ros.guarded_commands import GuardedCommands
from q2q_control.ros.legacy_topics import LegacyTopics
from q2q_model.ros.node.node_parameters import declare, on_change
from q2q_model.ros.node.run import run
from q2q_model.ros.node.tick import TickWiring
from q2q_model.signals.layout import Signal
from q2q_model.signals.values import Interference, SwarmCommand, SwarmSetpoint, SwarmState
from q2q_model.tunable import check_bounds, tunable
from q2q_model.vehicle.constants import vehicle_by_name
from q2q_model.vehicle.thrust_map import FIRMWARES, STOCK


@dataclass(frozen=True, slots=True)
class PidNodeParams:
    """Parameters of the node, without the controller's."""

    vehicle: str = tunable("crazyflie_2_0", "vehicle constants to use", read_only=True)
    firmware: str = tunable(STOCK, "its thrust per PWM", choices=FIRMWARES, read_only=True)
    vehicles: tuple[str, ...] = tunable((), "vehicles to command; empty: all of the setpoint", read_only=True)
    aware: bool = tunable(True, "compensate the predicted downwash", read_only=True)  # noqa: FBT003
    live: bool = tunable(
        default=False, description="watch the wall clock and fall back if a tick is missing", read_only=True
    )
    legacy_hz: float = tunable(
        10.0,
        "largest rate of <name>/cmd_vel_legacy; 0: not published",
        unit="Hz",
        low=0.0,
        high=1000.0,
        read_only=True,
    )

    def __post_init__(self) -> None:
        """Refuse values out of bounds."""
        check_bounds(self)


def build(node: Node) -> TickWiring[SwarmCommand]:
    """Wire the PID into a node; its gains may change in flight."""
    own = declare(node, PidNodeParams())
    vehicle = vehicle_by_name(own.vehicle, own.firmware)
    params = declare(node, PidParams(), in_flight=True)
    block = Pid(params, vehicle, own.vehicles)
    on_change(node, params, block.configure)
    inputs: dict[str, type[Signal]] = {"state": SwarmState, "reference_safe": SwarmSetpoint}
    if own.aware:
        inputs["interference"] = Interference
    wiring = TickWiring(node, inputs, ("command", SwarmCommand))
    wiring.after_publish(
        LegacyTopics(node, LegacyScale(vehicle.full_pwm_thrust), own.legacy_hz, own.vehicles).publish
    )
    guarded = GuardedCommands(block, declare(node, FallbackParams()), vehicle.hover_thrust, live=own.live)
    guarded.wire(node, wiring)
    wiring.rehearse(guarded.update, guarded.reset, own.vehicles)
    wiring.start(guarded.update)
    return wiring


def main() -> None:
    """Run the node `pid`."""
    run("pid", build)
