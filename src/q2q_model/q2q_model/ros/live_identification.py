"""Online refinement of a model in flight: `state`, `command`, `imu` in, latched `model` out."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from rclpy.node import Node
from std_msgs.msg import String

from q2q_model.files.model_file import ModelFile, encode, save
from q2q_model.identification.live import LiveEstimate, LiveParams, LiveRefinement
from q2q_model.ros.node.node_parameters import declare
from q2q_model.ros.node.run import run
from q2q_model.ros.topics.messages import MESSAGES
from q2q_model.ros.topics.qos import LATCHED, RECORD
from q2q_model.signals.cdr import SignalReader, header_stamp_ns
from q2q_model.signals.layout import Signal
from q2q_model.signals.tick_join import TickJoin
from q2q_model.signals.values import SwarmCommand, SwarmImu, SwarmState
from q2q_model.vehicle.constants import Vehicle

INPUTS: dict[str, type[Signal]] = {"state": SwarmState, "command": SwarmCommand, "imu": SwarmImu}


class LiveIdentification:
    """Online refinement and the publisher of its models."""

    def __init__(self, node: Node, base: ModelFile, vehicle: Vehicle) -> None:
        self._base, self._node = base, node
        self._params = declare(node, LiveParams())
        self._refinement = LiveRefinement(base.interaction, vehicle, self._params)
        self._publisher = node.create_publisher(String, "model", LATCHED)
        self._join: TickJoin[Signal] = TickJoin(tuple(INPUTS))
        self._sent_t, self._sent_gain = float("-inf"), 1.0
        for topic, signal in INPUTS.items():
            node.create_subscription(MESSAGES[signal], topic, self._receiver(topic, signal), RECORD, raw=True)

    @property
    def refined(self) -> ModelFile:
        """Return the current model."""
        return replace(self._base, interaction=self._refinement.refined())

    def _receiver(self, topic: str, signal: type[Signal]) -> Callable[[bytes], None]:
        reader = SignalReader(signal)

        def receive(data: bytes) -> None:
            values = self._join.put(topic, header_stamp_ns(data), reader.read(data))
            if values is not None:
                self._follow(self._refinement.update(*values))  # type: ignore[arg-type]  # in INPUTS' order

        return receive

    def _follow(self, estimate: LiveEstimate) -> None:
        """Publish the model if it has changed and `publish_every` has passed."""
        due = estimate.t - self._sent_t >= self._params.publish_every
        if due and abs(estimate.gain - self._sent_gain) >= self._params.change_min:
            self._sent_t, self._sent_gain = estimate.t, estimate.gain
            self._publisher.publish(String(data=encode(self.refined)))
            self._node.get_logger().info(f"gain {estimate.gain:.3f} at t = {estimate.t:.1f} s")


def refine_live(base: ModelFile, vehicle: Vehicle, out: Path) -> None:
    """Refine until SIGINT or SIGTERM, then save the last model in `out`."""
    run(
        "identify", lambda node: LiveIdentification(node, base, vehicle), lambda live: save(out, live.refined)
    )
