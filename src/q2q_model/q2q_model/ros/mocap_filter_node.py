"""Mocap filter node: `mocap` in, `state` out, with `<name>/pose` and `<name>/odom` for other software."""

from collections.abc import Callable
from dataclasses import asdict, dataclass

from rclpy.node import Node

from q2q_model.diagnostics.health import Health
from q2q_model.estimation.mocap_filter import MocapFilter
from q2q_model.estimation.mocap_filter_params import MocapFilterParams
from q2q_model.estimation.mocap_warnings import MocapWarnings
from q2q_model.estimation.stray_names import MOST_LOST
from q2q_model.ros.node.input_warnings import (
    StalledStampWarning,
    warn_of_unknown_names,
    warn_of_unprintable_names,
)
from q2q_model.ros.node.node_parameters import declare
from q2q_model.ros.node.run import run
from q2q_model.ros.node.tick_wiring import TickWiring
from q2q_model.ros.topics.vehicle_topics import VehicleTopics
from q2q_model.signals.values import MocapFrame, SwarmState
from q2q_model.tunable import check_bounds, tunable

CHANGING_NAMES = (
    f"{MOST_LOST} vehicles are lost, so new names are ignored: set the parameter vehicles to those that fly"
)


@dataclass(frozen=True, slots=True)
class MocapFilterNodeParams:
    """Parameters of the node in addition to those of the filter."""

    vehicles: tuple[str, ...] = tunable(
        (),
        f"names of the vehicles to track; empty: all that appear; no new ones once {MOST_LOST} are lost",
        read_only=True,
    )
    vehicle_topics_hz: float = tunable(
        10.0,
        "largest rate of <name>/pose and <name>/odom of a vehicle that is not LOST; 0: not published",
        unit="Hz",
        low=0.0,
        high=1000.0,
        read_only=True,
    )

    def __post_init__(self) -> None:
        """Check the bounds."""
        check_bounds(self)


def build(node: Node) -> TickWiring[SwarmState]:
    """Connect the filter to a node."""
    own = declare(node, MocapFilterNodeParams())
    params = declare(node, MocapFilterParams())
    block, spare = MocapFilter(params, own.vehicles), MocapFilter(params, own.vehicles)
    wiring = TickWiring(node, {"mocap": MocapFrame}, ("state", SwarmState))
    wiring.add_diagnostic_values(
        lambda: {f"mocap_{name}": str(count) for name, count in asdict(block.report).items()}
    )
    wiring.after_publish(VehicleTopics(node, own.vehicle_topics_hz, own.vehicles).publish)
    wiring.after_publish(warning_log(node, wiring.health, block))
    wiring.warm_up(spare.update, spare.reset, own.vehicles)  # keeps the counts of `block` at zero
    wiring.listen("mocap", warn_of_unprintable_names(node, "mocap"))
    wiring.listen("mocap", warn_of_unknown_names(node, "mocap", own.vehicles))
    wiring.listen("mocap", StalledStampWarning(node, "mocap", wiring.health).update)
    wiring.start(block.update)
    return wiring


def warning_log(node: Node, health: Health, block: MocapFilter) -> Callable[[int, SwarmState], None]:
    """Return a listener that logs, and keeps in `health`, what motion capture gets wrong."""
    warnings = MocapWarnings()

    def log(_: int, state: SwarmState) -> None:
        if line := warnings.update(state.t, block.warnings):
            node.get_logger().warning(line)
        health.doubts["mocap"] = warnings.text
        health.doubts["names"] = CHANGING_NAMES if block.refuses_names else ""
        if block.refuses_names:
            node.get_logger().warning(CHANGING_NAMES, once=True)

    return log


def main() -> None:
    """Run the node `mocap_filter`."""
    run("mocap_filter", build)
