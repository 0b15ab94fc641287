"""Play a plan as a node: `mocap` ticks in, `reference` out; the plan itself latched on `plan`."""

from dataclasses import dataclass
from pathlib import Path

from q2q_msgs.msg import Plan
from rclpy.node import Node

from q2q_model.parameters import check_bounds, tunable
from q2q_model.ros.parameters import declare
from q2q_model.ros.qos import LATCHED
from q2q_model.ros.ready import latched_is_out
from q2q_model.ros.run import run
from q2q_model.ros.tick import TickWiring
from q2q_model.signals import MocapFrame, SwarmSetpoint
from q2q_planner import plan_file
from q2q_planner.plan_clock import PlanClock
from q2q_planner.ros.plan_message import encode_plan
from q2q_planner.trajectory import setpoint_at


@dataclass(frozen=True, slots=True)
class TrajectoryParams:
    """Hold the node's parameters."""

    plan: str = tunable("", "plan file to play", read_only=True)
    start: float = tunable(
        -1.0, "stamp at which the plan starts; below 0: at the first tick", unit="s", read_only=True
    )

    def __post_init__(self) -> None:
        """Refuse values out of bounds."""
        check_bounds(self)


def build(node: Node) -> TickWiring[SwarmSetpoint]:
    """Wire the player of a plan into a node."""
    params = declare(node, TrajectoryParams())
    if not params.plan:
        raise ValueError(
            "parameter plan is empty: give a plan file, e.g. one made by `ros2 run q2q_planner plan`"
        )
    plan = plan_file.load(Path(params.plan))
    clock = PlanClock(params.start)
    latched = node.create_publisher(Plan, "plan", LATCHED)

    def update(frame: MocapFrame) -> SwarmSetpoint:
        if clock.starts_with(frame.t):
            latched.publish(encode_plan(plan, clock.start_ns))
        return setpoint_at(plan, frame.t, clock.start)

    if params.start >= 0.0:  # known before the first tick: whoever looks ahead has it in time
        latched.publish(encode_plan(plan, clock.start_ns))
        latched_is_out(node, latched)
    wiring = TickWiring(node, {"mocap": MocapFrame}, ("reference", SwarmSetpoint))
    wiring.start(update)
    return wiring


def main() -> None:
    """Run the node `trajectory`."""
    run("trajectory", build)
