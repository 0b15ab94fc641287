"""Controller of your own: `state`, `reference_safe` and (if aware) `interference` in, `command` out.

The parameter `controller` names a class with the methods of `q2q.Controller`, which is made with the vehicle
type as its only argument. If it has a method `sense`, it also gets `imu`. Its module is one of the current
folder or an installed one; PYTHONPATH is not searched where the set-up installed ROS:
`--ros-args -p controller:=my_module:MyController`. See docs/tutorials/own_controller.md.

The class is tried on a few ticks before the flight. When it raises an error in flight, or returns a command
that cannot be flown, the node reports it. Live, the vehicles are then levelled (LEVEL), and landed after
`land_after_s` (LAND), unless the class returns valid commands again. In lockstep the node ends.
"""

from collections.abc import Callable
from dataclasses import dataclass

from rclpy.node import Node

from q2q_control.own_controller.checked_controller import ControllerOutputError
from q2q_control.own_controller.find_controller import find_controller
from q2q_control.own_controller.level_on_error import LevelOnError
from q2q_control.ros.accelerometers import receive_accelerometers
from q2q_control.ros.controller_wiring import ControllerNodeParams, wire_controller
from q2q_model.diagnostics.health import Health
from q2q_model.node.warm_up import synthetic_signal
from q2q_model.ros.node.node_parameters import declare
from q2q_model.ros.node.run import NodeFailedError, run
from q2q_model.ros.node.tick_wiring import TickWiring
from q2q_model.signals.layout import Signal
from q2q_model.signals.values import SwarmCommand, SwarmImu
from q2q_model.tunable import tunable
from q2q_model.vehicle.constants import vehicle_by_name

DOUBT = "own controller"
"""Doubt of a controller that fails."""


@dataclass(frozen=True, slots=True)
class OwnControllerNodeParams:
    """Parameters of the node in addition to those of every controller node."""

    controller: str = tunable("", "class of the controller, as module:Class", read_only=True)


def build(node: Node) -> TickWiring[SwarmCommand]:
    """Wire the controller into a node, after a trial on a few ticks.

    Raises:
        ValueError: no class is named, or it is not found, cannot be made or fails in the trial.
    """
    own = declare(node, ControllerNodeParams())
    vehicle = vehicle_by_name(own.vehicle, own.firmware)
    name = declare(node, OwnControllerNodeParams()).controller
    if not name:
        example = "-p controller:=my_module:MyController"
        raise ValueError(f"parameter controller is empty: give a class as module:Class, e.g. {example}")
    checked = find_controller(name, vehicle)
    block = LevelOnError(checked) if own.live else checked
    wiring, guarded = wire_controller(node, own, vehicle, block)
    wiring.warm_up(checked.update, checked.reset, own.vehicles)
    imu = synthetic_signal(SwarmImu, 0.0, own.vehicles)
    if isinstance(imu, SwarmImu):
        checked.sense(imu)  # its error is raised by the next update
    wiring.warm_up(guarded.update, guarded.reset, own.vehicles)
    if checked.senses:
        receive_accelerometers(node, checked.sense, wiring.health)
    if isinstance(block, LevelOnError):
        wiring.after_publish(_ErrorReport(node, block, wiring.health).update)
    wiring.start(guarded.update if own.live else _ending(guarded.update))
    return wiring


class _ErrorReport:
    """Report of the errors of a class, each once in the log, the present one on `/diagnostics`."""

    def __init__(self, node: Node, block: LevelOnError, health: Health) -> None:
        self._log, self._block, self._health = node.get_logger(), block, health

    def update(self, *_: object) -> None:
        """Report the error of the last tick, if it had one."""
        if self._block.error and not self._health.doubts.get(DOUBT):
            self._log.error(self._block.error)
        self._health.doubts[DOUBT] = self._block.error


def _ending(update: Callable[..., SwarmCommand]) -> Callable[..., SwarmCommand]:
    """Return `update`, whose failure ends the node: in lockstep all others wait for its command."""

    def update_or_end(*signals: Signal) -> SwarmCommand:
        try:
            return update(*signals)
        except ControllerOutputError as error:
            raise NodeFailedError(str(error)) from error

    return update_or_end


def main() -> None:
    """Run the node `own_controller`."""
    run("own_controller", build)
