"""Run the interaction model as a node: `state` in, `interference` out; takes up models sent on `model`."""

from dataclasses import dataclass

from rclpy.node import Node

from q2q_model.interaction.predictor import InteractionPredictor
from q2q_model.parameters import check_bounds, tunable
from q2q_model.ros.parameters import declare
from q2q_model.ros.run import run
from q2q_model.ros.tick import TickWiring
from q2q_model.signals import Interference, SwarmState
from q2q_model.tools.models import find_model


@dataclass(frozen=True, slots=True)
class InterferenceParams:
    """Hold the node's parameters."""

    model: str = tunable("none", "interaction model: none, a shipped name, or a .q2q file", read_only=True)

    def __post_init__(self) -> None:
        """Refuse values out of bounds."""
        check_bounds(self)


def build(node: Node) -> TickWiring[Interference]:
    """Wire the predictor into a node."""
    params = declare(node, InterferenceParams())
    predictor = InteractionPredictor(find_model(params.model).interaction)
    wiring = TickWiring(node, {"state": SwarmState}, ("interference", Interference))
    wiring.rehearse(predictor.update, predictor.reset)
    wiring.start(predictor.update)
    return wiring


def main() -> None:
    """Run the node `interference`."""
    run("interference", build)
