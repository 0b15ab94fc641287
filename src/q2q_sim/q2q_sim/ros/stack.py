"""Nodes in one process: live from mocap_filter to controller, in lockstep all nodes of a flight.

Every node keeps its name, topics, services and parameters (one parameter file with a section for each node).
Within the process signals pass over a bus (q2q_model.signals.local_bus), and on ROS to whoever subscribes.
Without a recorder in the process the command is published before the signals that led to it.
"""

import sys
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass

from rclpy.node import Node

from q2q_control.ros import mpc_node, own_controller_node, pid_node
from q2q_model.ros import interference_node, mocap_filter_node
from q2q_model.ros.node.bus_node import BusNode
from q2q_model.ros.node.node_parameters import declare
from q2q_model.ros.node.run import run_together
from q2q_model.signals.local_bus import LocalBus
from q2q_model.tunable import check_bounds, tunable
from q2q_planner.ros import replanner_node, trajectory_node
from q2q_sim.processes.parameter_sections import misspelt_sections
from q2q_sim.ros.bag_record_node import Recorder
from q2q_sim.ros.simulator_node import Simulator
from q2q_sim.simulator.flight_output import OUTPUTS

CONTROL_LOOP: Mapping[str, Callable[[Node], object]] = {
    "mocap_filter": mocap_filter_node.build,
    "interference": interference_node.build,
    "trajectory": trajectory_node.build,
    "replanner": replanner_node.build,
    "pid": pid_node.build,
    "mpc": mpc_node.build,
    "own_controller": own_controller_node.build,
}
BUILDERS: Mapping[str, Callable[[Node], object]] = {
    **CONTROL_LOOP,
    "simulator": Simulator,
    "bag_record": Recorder,
}
ELSEWHERE = ("radio", "crazyswarm", "bag_play", "view")
"""Nodes of q2q that run in processes of their own."""
WRITES: Mapping[str, Collection[str]] = {
    "mocap_filter": ("state",),
    "interference": ("interference",),
    "trajectory": ("reference",),
    "replanner": ("reference_safe",),
    "pid": ("command",),
    "mpc": ("command",),
    "own_controller": ("command",),
    "simulator": OUTPUTS,
    "bag_record": (),
}
"""The tick topics of each."""


@dataclass(frozen=True, slots=True)
class StackParams:
    """Parameters of the process."""

    nodes: tuple[str, ...] = tunable(
        ("mocap_filter", "interference", "trajectory", "replanner", "pid"),
        "nodes to run in this process",
        read_only=True,
    )

    def __post_init__(self) -> None:
        """Check the bounds, and that the nodes are known, each once, with one controller."""
        check_bounds(self)
        unknown = [name for name in self.nodes if name not in BUILDERS]
        if unknown or not self.nodes:
            asked = ", ".join(unknown) or "none"
            raise ValueError(f"parameter nodes: {asked}; choose some of {', '.join(BUILDERS)}")
        if len(set(self.nodes)) < len(self.nodes):
            raise ValueError(f"parameter nodes: {', '.join(self.nodes)}; give each node once")
        controllers = [name for name in self.nodes if "command" in WRITES[name]]
        if len(controllers) > 1:
            raise ValueError(
                f"parameter nodes: {' and '.join(controllers)}; choose one, as each writes command"
            )


def build() -> dict[Node, object]:
    """Return every node with the objects that it needs to stay alive."""
    own = Node("stack")
    chosen = declare(own, StackParams()).nodes
    bus = LocalBus({topic for name in chosen for topic in WRITES[name]})
    made: dict[Node, object] = {own: None}
    for name in chosen:
        node = BusNode(name, bus)
        made[node] = BUILDERS[name](node)
    return made


def close_node(made: object) -> None:
    """Close the ports of a simulator and the bag of a recorder."""
    if isinstance(made, Simulator | Recorder):
        made.close()


def main() -> None:
    """Run the process `stack`."""
    run_together("stack", _build, close_node)


def _build() -> dict[Node, object]:
    """Return the nodes, after warnings of sections in parameter files that none of them reads."""
    made = build()
    own, *_ = made
    for note in misspelt_sections(sys.argv, [node.get_name() for node in made], (*BUILDERS, *ELSEWHERE)):
        own.get_logger().warning(note)
    return made
