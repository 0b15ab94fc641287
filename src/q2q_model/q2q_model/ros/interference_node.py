"""Interaction model node: predicts downwash: `state` in, `interference` out; loads models from `model`."""

from collections.abc import Callable
from dataclasses import dataclass
from time import monotonic

from rclpy.node import Node
from std_msgs.msg import String

from q2q_model.diagnostics.health import Health
from q2q_model.diagnostics.stopwatch import Stopwatch
from q2q_model.downwash.correction.corrected_predictor import CorrectedPredictor
from q2q_model.downwash.correction.residual_process import REAL_FLIGHTS
from q2q_model.downwash.predictor import InteractionPredictor
from q2q_model.model_files.find_model import find_model
from q2q_model.model_files.model_file import ModelFile, decode
from q2q_model.model_files.model_names import ModelFileError
from q2q_model.ros.measured_ticks import receive_measured_ticks
from q2q_model.ros.node.node_parameters import declare
from q2q_model.ros.node.run import run
from q2q_model.ros.node.tick_wiring import TickWiring
from q2q_model.ros.topics.qos import LATCHED
from q2q_model.signals.topic_names import MODEL
from q2q_model.signals.values import Interference, SwarmState
from q2q_model.tunable import check_bounds, tunable
from q2q_model.vehicle.constants import VEHICLES, vehicle_by_name


@dataclass(frozen=True, slots=True)
class InterferenceParams:
    """Parameters of the node."""

    model: str = tunable("none", "interaction model: none, a shipped name, or a .q2q file", read_only=True)
    correct_vehicle: str = tunable(
        "none",
        "vehicle type, needed to correct the prediction by `imu` and `command` of the last tick; "
        "none: no correction",
        choices=("none", *VEHICLES),
        read_only=True,
    )

    def __post_init__(self) -> None:
        """Check the bounds."""
        check_bounds(self)


def build(node: Node) -> TickWiring[Interference]:
    """Connect the predictor to a node."""
    params = declare(node, InterferenceParams())
    found = find_model(params.model)
    predictor = InteractionPredictor(found.interaction)
    wiring = TickWiring(node, {"state": SwarmState}, ("interference", Interference))
    age = Stopwatch(monotonic)
    wiring.add_diagnostic_values(lambda: {"model_age_s": f"{age.seconds():.0f}"})
    wiring.expect_one_publisher(MODEL)
    node.create_subscription(String, MODEL, model_receiver(node, predictor, age, wiring.health), LATCHED)
    block = predictor if params.correct_vehicle == "none" else corrected_predictor(predictor, params, found)
    if isinstance(block, CorrectedPredictor):
        receive_measured_ticks(node, block.sense, wiring.health.refuse)
    wiring.warm_up(block.update, block.reset)
    wiring.start(block.update)
    return wiring


def corrected_predictor(
    predictor: InteractionPredictor, params: InterferenceParams, found: ModelFile
) -> CorrectedPredictor:
    """Return the predictor corrected by the topics `imu` and `command`."""
    vehicle = vehicle_by_name(params.correct_vehicle)
    return CorrectedPredictor(predictor, found.residual or REAL_FLIGHTS, vehicle)


def model_receiver(
    node: Node, predictor: InteractionPredictor, age: Stopwatch, health: Health
) -> Callable[[String], None]:
    """Return a callback that loads a model file's text; an invalid one is refused, the last one kept."""

    def receive(message: String) -> None:
        try:
            predictor.exchange(decode(message.data).interaction)
            age.restart()
            node.get_logger().info("model loaded")
        except ModelFileError as refusal:
            health.refuse(f"model (the last one is kept): {refusal}")

    return receive


def main() -> None:
    """Run the node `interference`."""
    run("interference", build)
