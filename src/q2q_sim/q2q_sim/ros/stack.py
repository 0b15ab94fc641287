"""Nodes from mocap_filter to controller in one process, for the smallest latency.

Every node keeps its name, topics, services and parameters (one parameter file with a section for each node).
Within the process signals pass over a bus (q2q_model.signals.local_bus); the command is published before the
signals that led to it.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from rclpy.node import Node

from q2q_control.ros import mpc_node, pid_node
from q2q_model.ros import interference_node, mocap_filter_node
from q2q_model.ros.node.bus_node import BusNode
from q2q_model.ros.node.node_parameters import declare
from q2q_model.ros.node.run import run_together
from q2q_model.signals.local_bus import LocalBus
from q2q_model.tunable import check_bounds, tunable
from q2q_planner.ros import replanner_node, trajectory_node

BUILDERS: Mapping[str, Callable[[Node], object]] = {
    "mocap_filter": mocap_filter_node.build,
    "interference": interference_node.build,
    "trajectory": trajectory_node.build,
    "replanner": replanner_node.build,
    "pid": pid_node.build,
    "mpc": mpc_node.build,
}
WRITES = {
    "mocap_filter": "state",
    "interference": "interference",
    "trajectory": "reference",
    "replanner": "reference_safe",
    "pid": "command",
    "mpc": "command",
}
"""The tick topic of each."""


@dataclass(frozen=True, slots=True)
class StackParams:
    """Parameters of the process."""

    nodes: tuple[str, ...] = tunable(
        ("mocap_filter", "interference", "trajectory", "replanner", "pid"),
        "nodes to run in this process",
        read_only=True,
    )

    def __post_init__(self) -> None:
        """Check the bounds and the names of the nodes."""
        check_bounds(self)
        unknown = [name for name in self.nodes if name not in BUILDERS]
        if unknown or not self.nodes:
            asked = ", ".join(unknown) or "none"
            raise ValueError(f"parameter nodes: {asked}; choose some of {', '.join(BUILDERS)}")


def build() -> dict[Node, object]:
    """Return every node with the objects that it needs to stay alive."""
    own = Node("stack")
    chosen = declare(own, StackParams()).nodes
    bus = LocalBus({WRITES[name] for name in chosen})
    made: dict[Node, object] = {own: None}
    for name in chosen:
        node = BusNode(name, bus)
        made[node] = BUILDERS[name](node)
    return made


def main() -> None:
    """Run the process `stack`."""
    run_together("stack", build)
