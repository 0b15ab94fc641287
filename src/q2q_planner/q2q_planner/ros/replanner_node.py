"""Replanner node: `reference` and `state` in, replanned setpoints out on `reference_safe`.

The name `reference_safe` guarantees nothing. With `law:=paper`, the default, setpoints are moved by the
paper's potential field, without a guarantee; with `enabled:=false`, vehicles follow their references. Only
`law:=safe` guarantees separation, under the conditions in docs/promise.md and while a setpoint's status is
not PROMISE_BROKEN.

The node has only the parameters of its law; those of `safe` have the prefix `safe.`. They may change in
flight.
"""

from collections.abc import Callable
from dataclasses import dataclass

from rclpy.node import Node

from q2q_model.diagnostics.health import Health
from q2q_model.ros.node.node_parameters import declare, on_change, withhold
from q2q_model.ros.node.run import run
from q2q_model.ros.node.tick_wiring import TickWiring
from q2q_model.signals.values import SwarmSetpoint, SwarmState
from q2q_model.tunable import check_bounds, tunable
from q2q_planner.online.potential_field import PotentialField, PotentialFieldParams
from q2q_planner.online.replanner import Replanner
from q2q_planner.online.safe.motion.safe_replanner_params import SafeReplannerParams
from q2q_planner.online.safe.safe_replanner import SafeReplanner
from q2q_planner.online.setpoint_warnings import SetpointWarnings

PAPER, SAFE = "paper", "safe"
PREFIX = f"{SAFE}."
"""Prefix of the safe replanner's parameters, some of which have the names of the paper's."""


@dataclass(frozen=True, slots=True)
class ReplannerNodeParams:
    """Parameters of the node, without those of its law."""

    law: str = tunable(
        PAPER,
        "replanning law: the paper's potential field (paper), or the safe replanner (safe)",
        choices=(PAPER, SAFE),
        read_only=True,
    )

    def __post_init__(self) -> None:
        """Check the bounds."""
        check_bounds(self)


def build(node: Node) -> TickWiring[SwarmSetpoint]:
    """Wire the replanner into a node; its parameters may change in flight."""
    block = _block(node, declare(node, ReplannerNodeParams()).law)
    wiring = TickWiring(
        node, {"reference": SwarmSetpoint, "state": SwarmState}, ("reference_safe", SwarmSetpoint)
    )
    wiring.warm_up(block.update, block.reset)
    wiring.after_publish(_warning_log(node, wiring.health))
    wiring.start(block.update)
    return wiring


def _block(node: Node, law: str) -> Replanner:
    if law == SAFE:
        safe = declare(node, SafeReplannerParams(), PREFIX, in_flight=True)
        guarded = SafeReplanner(safe)
        on_change(node, safe, guarded.configure, PREFIX)
        withhold(node, PotentialFieldParams(), f"law:={PAPER}")
        return guarded
    paper = declare(node, PotentialFieldParams(), in_flight=True)
    field = PotentialField(paper)
    on_change(node, paper, field.configure)
    withhold(node, SafeReplannerParams(), f"law:={SAFE}", PREFIX)
    return field


def _warning_log(node: Node, health: Health) -> Callable[[int, SwarmSetpoint], None]:
    """Return a listener that logs, and keeps in `health`, what is wrong with setpoints."""
    warnings = SetpointWarnings()

    def log(_: int, setpoint: SwarmSetpoint) -> None:
        if line := warnings.update(setpoint):
            node.get_logger().warning(line)
        health.doubts["reference_safe"] = warnings.text

    return log


def main() -> None:
    """Run the node `replanner`."""
    run("replanner", build)
