"""View of a running flight: signals in, `scene` (MarkerArray) out, and optionally a Foxglove server.

RViz: `rviz2 -d` with the shipped `config/q2q.rviz`. Foxglove: `-p foxglove:=true`, then open a WebSocket
connection to ws://localhost:8765 and import the shipped `config/foxglove_layout.json`. q2q_sim.view.scene
lists what is drawn. The node subscribes best effort, so that it cannot delay a flight.
"""

from dataclasses import dataclass

from q2q_msgs.msg import Plan
from rclpy.node import Node
from visualization_msgs.msg import MarkerArray

from q2q_model.diagnostics.health import Health
from q2q_model.node.decimation import Decimation
from q2q_model.ros.node.diagnostics_publisher import publish_health
from q2q_model.ros.node.node_parameters import declare
from q2q_model.ros.node.run import run
from q2q_model.ros.topics.messages import MESSAGES
from q2q_model.ros.topics.plan_message import decode_plan
from q2q_model.ros.topics.qos import LATCHED, OUTSIDE
from q2q_model.ros.topics.subscriptions import listener
from q2q_model.signals.layout import Signal
from q2q_model.signals.topic_names import PLAN
from q2q_model.signals.values import Interference, SwarmSetpoint, SwarmState
from q2q_model.tunable import check_bounds, tunable
from q2q_sim.ros.scene_markers import marker_array
from q2q_sim.view.foxglove_server import FoxgloveScene
from q2q_sim.view.scene import SceneBuilder, SceneParams, scene_signals

INPUTS: dict[str, type[Signal]] = {
    "state": SwarmState,
    "interference": Interference,
    "reference": SwarmSetpoint,
    "reference_safe": SwarmSetpoint,
}
FOXGLOVE_PORT = 8765
"""Foxglove's default port (docs.foxglove.dev)."""


@dataclass(frozen=True, slots=True)
class ViewParams:
    """Parameters of the node."""

    scene_hz: float = tunable(
        20.0,
        "largest rate of the scene, by the stamps of the signals",
        unit="Hz",
        low=0.1,
        high=100.0,
        read_only=True,
    )
    foxglove: bool = tunable(False, "serve the scene to Foxglove on this machine", read_only=True)  # noqa: FBT003
    foxglove_port: int = tunable(
        FOXGLOVE_PORT, "TCP port for Foxglove; 0 lets the system choose", low=0, high=65535, read_only=True
    )

    def __post_init__(self) -> None:
        """Check the bounds."""
        check_bounds(self)


class View:
    """Scene memory, last signals and viewers."""

    def __init__(self, node: Node) -> None:
        """Subscribe, and open the Foxglove server if requested.

        Raises:
            ValueError: foxglove-sdk is required and not installed.
            OSError: its port is taken.
        """
        params = declare(node, ViewParams())
        self._builder = SceneBuilder(declare(node, SceneParams()))
        self._due = Decimation(params.scene_hz)
        self._health = Health()
        self._last: dict[str, Signal] = {}
        self._markers = node.create_publisher(MarkerArray, "scene", 1)
        self.foxglove = FoxgloveScene(params.foxglove_port) if params.foxglove else None
        if self.foxglove is not None:
            node.get_logger().info(f"Foxglove: ws://localhost:{self.foxglove.port}")
        for topic, signal in INPUTS.items():
            self._listen(node, topic, signal)
        node.create_subscription(Plan, PLAN, self._on_plan, LATCHED)
        publish_health(node, self._health)

    def close(self) -> None:
        """Close the Foxglove server."""
        if self.foxglove is not None:
            self.foxglove.close()

    def _listen(self, node: Node, topic: str, signal: type[Signal]) -> None:
        def take(stamp_ns: int, value: Signal) -> None:
            self._take(topic, stamp_ns, value)

        receive = listener(topic, signal, take, self._health.refuse)
        node.create_subscription(MESSAGES[signal], topic, receive, OUTSIDE, raw=True)

    def _on_plan(self, message: Plan) -> None:
        try:
            self._builder.take_plan(decode_plan(message))
        except ValueError as refusal:
            self._health.refuse(f"plan: {refusal}")

    def _take(self, topic: str, stamp_ns: int, value: Signal) -> None:
        self._last[topic] = value
        if not isinstance(value, SwarmState) or not self._due(value.t):
            return
        scene = self._builder.update(scene_signals(value, self._last))
        self._markers.publish(marker_array(scene, stamp_ns))
        if self.foxglove is not None:
            self.foxglove.show(scene, stamp_ns)
        self._health.ticks += 1


def main() -> None:
    """Run the node `view`."""
    run("view", View, View.close)
