"""What the node `interference` says of models that come in flight, and which one it flies with."""

import pytest

pytest.importorskip("q2q_msgs", reason="the workspace is not built")

from room_node import RoomNode
from std_msgs.msg import String

from q2q_model.diagnostics.health import Health, Level, health_report
from q2q_model.downwash.jet import Jet
from q2q_model.model_files.find_model import find_model
from q2q_model.model_files.model_file import ModelFile, encode
from q2q_model.ros import interference_node
from q2q_model.ros.node.tick_wiring import TickWiring
from q2q_model.signals.values import Interference


def flying() -> tuple[RoomNode, TickWiring[Interference]]:
    """Return a node with the paper's law, and its wiring."""
    node = RoomNode("interference", {"model": "paper_law"}, {})
    return node, interference_node.build(node)


def test_a_refused_model_is_an_error_of_health_and_floods_no_log() -> None:
    node, wiring = flying()
    for _ in range(500):
        node.takers["model"](String(data="garbage"))
    graded = health_report(Health(), wiring.health)
    assert graded.level is Level.ERROR
    assert graded.trouble  # which the log has once a text
    assert graded.summary.startswith("refused: model (the last one is kept): not complete JSON")
    assert node.lines == []


def test_a_model_that_would_throw_vehicles_to_the_ceiling_is_refused() -> None:
    node, wiring = flying()
    rising = Jet(strength=20.0, decay="exponential", decay_rate=-5.0, range=10.0)
    node.takers["model"](String(data=encode(ModelFile(rising))))
    assert "must be at most 49.1 (5 g)" in wiring.health.last_refusal


def test_a_model_after_refused_ones_is_loaded() -> None:
    node, wiring = flying()
    node.takers["model"](String(data="[1, 2]"))
    node.takers["model"](String(data=encode(find_model("measured_law"))))
    assert node.lines == ["model loaded"]
    assert wiring.health.refused == 1
