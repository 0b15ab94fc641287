"""Trajectory node: plays a plan: `mocap` in for its ticks, `reference` out; the plan is latched on `plan`.

With `wait:=true` the plan waits for service calls, and is latched on `next_plan`. Until the first call the
reference is at the measured positions of the vehicles. Without it the plan begins at the first tick, or at
`start`, with its first points as references, wherever the vehicles are, also in a node restarted in flight.

| service | effect |
|---|---|
| `~/transit` | moves the reference to the plan's first points; certified to keep the vehicles apart |
| `~/start` | starts the plan |
| `~/hold` | brakes along the plan, then keeps the reference there |
| `~/wait` | waits again, after a landing; refused while a vehicle is within 0.25 m of its reference (1) |
| `~/wait_landed` | the same without this check, for callers that know all vehicles to be on the ground |

(1) In flight, it would follow its own measured position, and drift.

For real vehicles, the nodes `radio` and `crazyswarm` call these services (docs/real_vehicles.md).
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from q2q_msgs.msg import Plan
from rclpy.node import Node
from rclpy.publisher import Publisher
from std_srvs.srv import Trigger

from q2q_model.node.reply import Reply
from q2q_model.ros.node.node_parameters import declare
from q2q_model.ros.node.ready import note_latched
from q2q_model.ros.node.run import run
from q2q_model.ros.node.tick_wiring import TickWiring
from q2q_model.ros.topics.plan_message import encode_plan
from q2q_model.ros.topics.qos import LATCHED
from q2q_model.signals.topic_names import NEXT_PLAN, PLAN
from q2q_model.signals.values import MocapFrame, SwarmSetpoint
from q2q_model.trajectory.polynomials import setpoint_at
from q2q_model.tunable import check_bounds, tunable
from q2q_planner.offline.certificate.certified_file import load_plan
from q2q_planner.plan_playback.plan_player import PlanPlayer, Played
from q2q_planner.plan_playback.transit import TransitParams

LAST_STAMP = 2147483647.0
"""Last second of a message's stamp [s]: its seconds are an int32 (builtin_interfaces/Time)."""


@dataclass(frozen=True, slots=True)
class TrajectoryParams:
    """Parameters of the node, without those of the transit."""

    plan: str = tunable("", "plan file to play", read_only=True)
    start: float = tunable(
        -1.0,
        "stamp at which the plan starts; refused with wait; negative: stamp of the first tick",
        unit="s",
        high=LAST_STAMP,
        read_only=True,
    )
    wait: bool = tunable(
        default=False, description="wait for service calls before playing the plan", read_only=True
    )

    def __post_init__(self) -> None:
        """Check the bounds."""
        check_bounds(self)


def build(node: Node) -> TickWiring[SwarmSetpoint]:
    """Wire a plan player into a node."""
    params = declare(node, TrajectoryParams())
    if not params.plan:
        raise ValueError(
            "parameter plan is empty: give a plan file, e.g. one written by `ros2 run q2q_planner plan`"
        )
    plan = load_plan(Path(params.plan))
    player = PlanPlayer(plan, params.start, declare(node, TransitParams()), wait=params.wait)
    played = _PlayedPlan(player, node.create_publisher(Plan, PLAN, LATCHED), node.get_logger().info)
    if player.played is not None:  # known before the first tick, in time for previews
        note_latched(node, played.publisher)
    played.publish()
    if params.wait:
        waiting = node.create_publisher(Plan, NEXT_PLAN, LATCHED)
        waiting.publish(encode_plan(plan, 0))
        note_latched(node, waiting)
    calls = {
        "wait": player.wait,
        "wait_landed": player.wait_landed,
        "transit": player.transit,
        "start": player.start,
        "hold": player.hold,
    }
    for name, act in calls.items():
        node.create_service(Trigger, f"~/{name}", played.service(act))

    def update(frame: MocapFrame) -> SwarmSetpoint:
        setpoint = player.update(frame)
        played.publish()
        return setpoint

    wiring = TickWiring(node, {"mocap": MocapFrame}, ("reference", SwarmSetpoint))
    wiring.expect_one_publisher(PLAN)
    wiring.warm_up(lambda frame: setpoint_at(plan, frame.t), lambda: None)
    wiring.start(update)
    return wiring


class _PlayedPlan:
    """Publisher of the plan that is played."""

    def __init__(self, player: PlanPlayer, publisher: Publisher, log: Callable[[str], object]) -> None:
        self.publisher, self._log = publisher, log
        self._player = player
        self._last: Played | None = None

    def publish(self) -> None:
        """Publish the plan if it has changed; log the start of one that no call began."""
        played = self._player.played
        if played is not None and played is not self._last:
            self.publisher.publish(encode_plan(played.plan, played.start_ns))
            if not played.called:
                self._log(f"the plan begins at stamp {played.start:.3f} s")
        self._last = played

    def service(
        self, act: Callable[[], Reply]
    ) -> Callable[[Trigger.Request, Trigger.Response], Trigger.Response]:
        """Return the callback of a service that acts, then publishes the plan if it has changed."""

        def answer(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
            reply = act()
            self.publish()
            response.success, response.message = reply.granted, reply.reason
            return response

        return answer


def main() -> None:
    """Run the node `trajectory`."""
    run("trajectory", build)
