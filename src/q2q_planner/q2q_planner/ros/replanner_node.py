"""Run the online replanner as a node: `reference` and `state` in, `reference_safe` out.

`law` chooses between the paper's potential field and the law with a promise; each has its own parameters,
those of the second under `safe.`. `enabled` and `safe.enabled` may change while flying.
"""

from dataclasses import dataclass

from rclpy.node import Node

from q2q_model.parameters import check_bounds, tunable
from q2q_model.ros.parameters import declare, on_change
from q2q_model.ros.run import run
from q2q_model.ros.tick import TickWiring
from q2q_model.signals import SwarmSetpoint, SwarmState
from q2q_planner.potential_field import PotentialField, PotentialFieldParams
from q2q_planner.replanner import Replanner
from q2q_planner.safe_params import SafeReplannerParams
from q2q_planner.safe_replanner import SafeReplanner

SAFE = "safe"
PREFIX = f"{SAFE}."
"""Before the names of the safe law's parameters, as some are named like the paper's."""


@dataclass(frozen=True, slots=True)
class ReplannerNodeParams:
    """Parameters of the node beside those of a law."""

    law: str = tunable("paper", "which law moves the setpoints", choices=("paper", SAFE), read_only=True)

    def __post_init__(self) -> None:
        """Refuse values out of bounds."""
        check_bounds(self)


def build(node: Node) -> TickWiring[SwarmSetpoint]:
    """Wire the replanner into a node; its parameters may change in flight."""
    block = _block(node, declare(node, ReplannerNodeParams()).law)
    wiring = TickWiring(
        node, {"reference": SwarmSetpoint, "state": SwarmState}, ("reference_safe", SwarmSetpoint)
    )
    wiring.rehearse(block.update, block.reset)
    wiring.start(block.update)
    return wiring


def _block(node: Node, law: str) -> Replanner:
    paper = declare(node, PotentialFieldParams(), in_flight=law != SAFE)
    safe = declare(node, SafeReplannerParams(), PREFIX, in_flight=law == SAFE)
    if law == SAFE:
        guarded = SafeReplanner(safe)
        on_change(node, safe, guarded.configure, PREFIX)
        return guarded
    field = PotentialField(paper)
    on_change(node, paper, field.configure)
    return field


def main() -> None:
    """Run the node `replanner`."""
    run("replanner", build)
