"""Online refinement of a model in flight: `state`, `command`, `imu` in, latched `model` out."""

from pathlib import Path

from rclpy.node import Node
from std_msgs.msg import String

from q2q_model.identification.carried_weight import CarriedWeight
from q2q_model.identification.online_refinement import (
    OnlineEstimate,
    OnlineRefinement,
    OnlineRefinementParams,
    PublishedGain,
    limit_reached,
)
from q2q_model.identification.refined_model import refined_file
from q2q_model.model_files.model_file import ModelFile, encode, save
from q2q_model.ros.measured_ticks import receive_measured_ticks
from q2q_model.ros.node.node_parameters import declare
from q2q_model.ros.node.run import run
from q2q_model.ros.topics.qos import LATCHED
from q2q_model.signals.topic_names import MODEL
from q2q_model.signals.values import SwarmCommand, SwarmImu, SwarmState
from q2q_model.vehicle.constants import Vehicle

REFUSALS_S = 10.0
"""Shortest time between two lines on refused messages, on a wrong vehicle, or on a gain at its limit [s]."""


class OnlineIdentification:
    """Online refinement and the publisher of its models."""

    def __init__(self, node: Node, base: ModelFile, vehicle: Vehicle) -> None:
        self._base, self._node = base, node
        params = declare(node, OnlineRefinementParams())
        self._refinement = OnlineRefinement(base.interaction, vehicle, params)
        self._carried = CarriedWeight(vehicle)
        self._publisher = node.create_publisher(String, MODEL, LATCHED)
        self._published = PublishedGain(self._refinement.params)
        self._ticks, self._gain = 0, 1.0
        self._join = receive_measured_ticks(node, self._take, self._refuse)

    @property
    def refined(self) -> ModelFile:
        """Return the current model."""
        return refined_file(self._base, self._refinement.refined(), self._gain)

    def _take(self, state: SwarmState, command: SwarmCommand, imu: SwarmImu) -> None:
        self._ticks += 1
        self._carried.update(state, command)
        estimate = self._refinement.update(state, command, imu)
        self._gain = estimate.gain
        if doubt := self._carried.doubt():
            self._node.get_logger().error(f"no model: {doubt}", throttle_duration_sec=REFUSALS_S)
        elif self._carried.judged():
            self._follow(estimate)

    def _refuse(self, reason: str) -> None:
        self._node.get_logger().warning(f"refused: {reason}", throttle_duration_sec=REFUSALS_S)

    def _follow(self, estimate: OnlineEstimate) -> None:
        """Publish the model if it is due."""
        if self._published.update(estimate):
            self._publisher.publish(String(data=encode(self.refined)))
            self._node.get_logger().info(f"gain {estimate.gain:.3f} at t = {estimate.t:.1f} s")
        if limit := limit_reached(estimate, self._refinement.params):
            self._node.get_logger().warning(
                f"gain is held at its limit {limit}: the model, --vehicle or a sensor does not fit",
                throttle_duration_sec=REFUSALS_S,
            )

    def end(self, out: Path) -> str:
        """Save the last model; return why none is saved, empty if it is."""
        nothing = "" if self._ticks else f"no complete tick: {self._join.lacking()}"
        reason = nothing or self._carried.doubt()
        if not reason:
            save(out, self.refined)
        return reason


def refine_online(base: ModelFile, vehicle: Vehicle, out: Path) -> str:
    """Refine until SIGINT or SIGTERM, then save the last model in `out`; return why none is saved, or ""."""
    reasons: list[str] = []
    run(
        "identify",
        lambda node: OnlineIdentification(node, base, vehicle),
        lambda online: reasons.append(online.end(out)),
    )
    return "".join(reasons)
