"""Run the online replanner as a node: `reference` and `state` in, `reference_safe` out."""

from rclpy.node import Node

from q2q_model.ros.parameters import declare, on_change
from q2q_model.ros.run import run
from q2q_model.ros.tick import TickWiring
from q2q_model.signals import SwarmSetpoint, SwarmState
from q2q_planner.potential_field import PotentialField, PotentialFieldParams


def build(node: Node) -> TickWiring[SwarmSetpoint]:
    """Wire the replanner into a node; its parameters may change in flight."""
    params = declare(node, PotentialFieldParams())
    block = PotentialField(params)
    on_change(node, params, block.configure)
    wiring = TickWiring(
        node, {"reference": SwarmSetpoint, "state": SwarmState}, ("reference_safe", SwarmSetpoint)
    )
    wiring.rehearse(block.update, block.reset)
    wiring.start(block.update)
    return wiring


def main() -> None:
    """Run the node `replanner`."""
    run("replanner", build)
