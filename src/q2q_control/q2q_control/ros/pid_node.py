"""PID node: `state`, `reference_safe` and (if aware) `interference` in, `command` out.

The default gains are the paper's. Their altitude loop is soft and has no integral: a thrust error of 1 %
gives a height error of 12 cm. Real vehicles, and simulated rooms with wind, battery voltage or unmodelled
downwash, need other gains, such as those in `src/q2q_control/config`:
`--ros-args --params-file src/q2q_control/config/pid_tuned.yaml`.
"""

from dataclasses import dataclass

from rclpy.node import Node

from q2q_control.disturbance.tracker import TrackerParams
from q2q_control.pid.gains_file import soft_altitude
from q2q_control.pid.observed_pid import ObservedPid
from q2q_control.pid.pid import Pid
from q2q_control.pid.pid_params import PidParams
from q2q_control.ros.accelerometers import receive_accelerometers
from q2q_control.ros.controller_wiring import ControllerNodeParams, CorrectionNodeParams, wire_controller
from q2q_model.downwash.correction.residual_process import REAL_FLIGHTS
from q2q_model.model_files.find_model import find_model
from q2q_model.ros.node.node_parameters import declare, on_change, withhold
from q2q_model.ros.node.run import run
from q2q_model.ros.node.tick_wiring import TickWiring
from q2q_model.signals.values import SwarmCommand
from q2q_model.tunable import tunable
from q2q_model.vehicle.constants import Vehicle, vehicle_by_name


@dataclass(frozen=True, slots=True)
class PidNodeParams:
    """Parameters of the node in addition to those of every controller node."""

    model: str = tunable(
        "none",
        "with correct: interaction model that gives the statistics of the prediction's error: none, a"
        " shipped name, or a .q2q file",
        read_only=True,
    )


def build(node: Node) -> TickWiring[SwarmCommand]:
    """Wire the PID into a node; its gains may change in flight."""
    own = declare(node, ControllerNodeParams())
    vehicle = vehicle_by_name(own.vehicle, own.firmware)
    params = declare(node, PidParams(), in_flight=True)
    if own.live and (warning := soft_altitude(params)):
        node.get_logger().warning(warning)
    correct = declare(node, CorrectionNodeParams()).correct
    choose = _correcting_pid if correct else _plain_pid
    block = choose(node, own, params, vehicle)
    on_change(node, params, block.configure)
    wiring, guarded = wire_controller(node, own, vehicle, block)
    if isinstance(block, ObservedPid):
        receive_accelerometers(node, block.sense, wiring.health)
    wiring.warm_up(guarded.update, guarded.reset, own.vehicles)
    wiring.start(guarded.update)
    return wiring


def _plain_pid(node: Node, own: ControllerNodeParams, params: PidParams, vehicle: Vehicle) -> Pid:
    """Return the PID that takes the downwash as predicted."""
    for absent in (PidNodeParams(), TrackerParams()):
        withhold(node, absent, "correct:=true")
    return Pid(params, vehicle, own.vehicles)


def _correcting_pid(
    node: Node, own: ControllerNodeParams, params: PidParams, vehicle: Vehicle
) -> ObservedPid:
    """Return the PID that corrects the predicted downwash."""
    residual = find_model(declare(node, PidNodeParams()).model).residual or REAL_FLIGHTS
    return ObservedPid(params, declare(node, TrackerParams()), vehicle, own.vehicles, residual)


def main() -> None:
    """Run the node `pid`."""
    run("pid", build)
