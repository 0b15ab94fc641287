"""PID node: `state`, `reference_safe` and (if aware) `interference` in, `command` out."""

from rclpy.node import Node

from q2q_control.pid.pid import Pid, PidParams
from q2q_control.ros.controller_wiring import ControllerNodeParams, wire_controller
from q2q_model.ros.node.node_parameters import declare, on_change
from q2q_model.ros.node.run import run
from q2q_model.ros.node.tick import TickWiring
from q2q_model.signals.values import SwarmCommand
from q2q_model.vehicle.constants import vehicle_by_name


def build(node: Node) -> TickWiring[SwarmCommand]:
    """Wire the PID into a node; its gains may change in flight."""
    own = declare(node, ControllerNodeParams())
    vehicle = vehicle_by_name(own.vehicle, own.firmware)
    params = declare(node, PidParams(), in_flight=True)
    block = Pid(params, vehicle, own.vehicles)
    on_change(node, params, block.configure)
    wiring, guarded = wire_controller(node, own, vehicle, block)
    wiring.rehearse(guarded.update, guarded.reset, own.vehicles)
    wiring.start(guarded.update)
    return wiring


def main() -> None:
    """Run the node `pid`."""
    run("pid", build)
